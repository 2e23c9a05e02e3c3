#pragma once

#include "bench/run/stage.h"

namespace ertbench {

/// Cross-validation on measured frames (Folds), a job for each solver and fold. A study
/// (bench/studies) is made of what comes out.
class FoldsStage final : public Stage {
 public:
  std::string name() const override;
  std::string noun() const override;
  std::vector<Job> jobs(const Experiment& experiment) const override;
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override;
  std::string key(const Experiment& experiment, const Job& job) const override;
  nlohmann::json run(const Job& job, const JobContext& context) const override;
  void check(const Experiment& experiment, const nlohmann::json& record) const override;
  void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
               ExperimentResults& results) const override;
};

}  // namespace ertbench
