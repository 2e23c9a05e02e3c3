#pragma once

#include "bench/run/stage.h"

namespace ertbench {

/// Whose times a run takes as they are: of processors like this machine's alone, or of any, as the
/// nodes of a cluster may have, where the rows say which.
enum class Machines { this_one, any };

/// Times every fitted solver, one frame at a time on one thread, then on batches. The frames are
/// shared out among rounds, and those of all solvers run in turn, so that what disturbs the machine
/// for a while falls on all of them. Its results are the rows' times.
class TimingStage : public Stage {
 public:
  explicit TimingStage(Machines machines = Machines::this_one) : machines_(machines) {}

  std::string name() const override;
  std::string noun() const override;
  bool wants_machine_alone() const override { return true; }
  std::vector<Job> jobs(const Experiment& experiment) const override;
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override;
  std::string key(const Experiment& experiment, const Job& job) const override;
  nlohmann::json run(const Job& job, const JobContext& context) const override;
  void check(const Experiment& experiment, const nlohmann::json& record) const override;
  std::string why_not_here(const nlohmann::json& record) const override;
  bool in_one_go() const override { return true; }
  void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
               ExperimentResults& results) const override;

 private:
  Machines machines_;
};

}  // namespace ertbench
