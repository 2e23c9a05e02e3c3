#pragma once

#include <string>
#include <vector>

#include "bench/studies/consistency_scores.h"
#include "bench/studies/study.h"

namespace ertbench {

struct ConsistencyOfSolver {
  std::string label;
  std::string failure;  ///< why there is nothing; else empty
  std::optional<StudyInput::Latency> latency;
  MeasuredPath path;
  ConsistencyScores scores;
};

/// One test set of frames in which one thing moves.
struct ConsistentSet {
  std::string name;
  std::string empty;  ///< the test set of frames without anything
  std::vector<ConsistencyOfSolver> solvers;
};

/// Measured frames without a truth: how constant what should be constant is, how smooth the path,
/// what the image explains of the voltages, how far methods agree, and what they see where nothing
/// is.
class Consistency : public StudyResult {
 public:
  explicit Consistency(const StudyInput& input);

  nlohmann::json summary() const override;
  std::vector<Headline> headlines() const override;
  std::vector<ReportSection> report(const std::string& title,
                                    const std::filesystem::path& folder) const override;

 private:
  std::string name_;
  Sensor sensor_;
  double outlier_mm_;
  std::vector<ConsistentSet> sets_;
};

}  // namespace ertbench
