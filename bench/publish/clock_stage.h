#pragma once

#include <optional>
#include <set>
#include <string>

#include "bench/run/timing_stage.h"

namespace ertbench {

/// The timing stage for some labels of an experiment, without the stages before it: the first entry
/// of each label is fitted where it is not in the cache, and timed. What is to be in one go is up
/// to the caller.
class ClockStage final : public Stage {
 public:
  /// Which of a stage's jobs are due: those of `round` alone, or all. Unless `alone`, several run
  /// at a time, for fits that the clock then finds in the cache.
  ClockStage(std::set<std::string> labels, std::optional<int> round, bool alone)
      : labels_(std::move(labels)), round_(round), alone_(alone) {}

  std::string name() const override { return timing_.name(); }
  std::string noun() const override { return timing_.noun(); }
  bool wants_machine_alone() const override { return alone_; }
  std::vector<Job> jobs(const Experiment& experiment) const override {
    return timing_.jobs(experiment);
  }
  std::vector<Job> due(const Experiment& experiment,
                       const ExperimentResults& results) const override;
  std::string key(const Experiment& experiment, const Job& job) const override {
    return timing_.key(experiment, job);
  }
  nlohmann::json run(const Job& job, const JobContext& context) const override;
  void check(const Experiment& experiment, const nlohmann::json& record) const override {
    timing_.check(experiment, record);
  }
  std::string why_not_here(const nlohmann::json& record) const override {
    return timing_.why_not_here(record);
  }
  void collect(const Experiment& experiment, const Cache& cache, const JobRecords& records,
               ExperimentResults& results) const override {
    timing_.collect(experiment, cache, records, results);
  }

 private:
  TimingStage timing_;
  std::set<std::string> labels_;
  std::optional<int> round_;
  bool alone_;
};

}  // namespace ertbench
