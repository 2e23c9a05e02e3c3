#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace ertbench {

struct ReportSection;  // bench/report/report.h

/// What came out of one study (StudySpec).
class StudyResult {
 public:
  virtual ~StudyResult() = default;

  /// All numbers, for summary.json; each with its interval where it has one.
  virtual nlohmann::json summary() const = 0;
  /// Draws the study's figures, writes its tables beside them, and returns its sections of the
  /// report. `title` is the experiment's.
  virtual std::vector<ReportSection> report(const std::string& title,
                                            const std::filesystem::path& folder) const = 0;
};

struct StudyOutcome {
  std::string name;
  std::string type;
  std::shared_ptr<const StudyResult> result;
};

}  // namespace ertbench
