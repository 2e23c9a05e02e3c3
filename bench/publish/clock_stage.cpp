#include "bench/publish/clock_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace ertbench {

std::vector<Job> ClockStage::due(const Experiment& experiment, const ExperimentResults&) const {
  std::set<const SolverEntry*> timed;
  for (const std::span<const SolverEntry> entries : experiment.rows()) {
    if (labels_.count(entries.front().label) > 0) timed.insert(&entries.front());
  }
  std::vector<Job> due = jobs(experiment);
  std::erase_if(due, [&](const Job& job) {
    return timed.count(job.entry) == 0 || (round_ && job.round != *round_);
  });
  return due;
}

nlohmann::json ClockStage::run(const Job& job, const JobContext& context) const {
  return timing_.run(job, context);
}

}  // namespace ertbench
