#pragma once

#include "bench/run/stage.h"

namespace ertbench {

/// Times every fitted solver, one frame at a time on one thread, then on batches. The frames are
/// shared out among rounds, and those of all solvers run in turn, so that what disturbs the machine
/// for a while falls on all of them. Its results are the rows' times.
class TimingStage : public Stage {
 public:
  std::string name() const override;
  std::string noun() const override;
  bool wants_machine_alone() const override { return true; }
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
