#pragma once

#include "bench/run/stage.h"

namespace ertbench {

/// Fits every solver (or takes it from the cache), reconstructs every test set and scores each
/// frame. Its results are the rows, the images of the figure and the logs of training.
class AccuracyStage : public Stage {
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
  void forget(const Experiment& experiment, const Cache& cache, const Job& job) const override;
};

}  // namespace ertbench
