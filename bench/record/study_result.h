#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ertbench {

struct ReportSection;  // bench/report/report.h

/// One of the few numbers by which a study's solvers are told apart: what is compared where a
/// solver was trained more than once.
struct Headline {
  std::string label;            ///< of the solver
  std::string what;             ///< with condition and unit: "disc_10N: median, thresholded (mm)"
  int decimals = 2;             ///< that it is shown with
  std::optional<double> value;  ///< nothing where it is undefined
};

/// What came out of one study (StudySpec).
class StudyResult {
 public:
  virtual ~StudyResult() = default;

  /// All numbers, for summary.json; each with its interval where it has one.
  virtual nlohmann::json summary() const = 0;
  /// Of every solver that did not fail; none of a study whose trainings are not compared.
  virtual std::vector<Headline> headlines() const { return {}; }
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
