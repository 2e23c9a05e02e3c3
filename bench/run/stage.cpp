#include "bench/run/stage.h"

#include <nlohmann/json.hpp>

namespace ertbench {

std::vector<ReportSection> Stage::report(const Experiment&, const ExperimentResults&,
                                         const std::filesystem::path&) const {
  return {};
}

std::string Stage::why_not_here(const nlohmann::json&) const { return ""; }

void Stage::forget(const Experiment&, const Cache&, const Job&) const {}

Job job_of(const Stage& stage, const SolverEntry& entry) {
  return {entry.stem() + "." + stage.name(), entry.stem(), entry.title(), &entry, 0};
}

Job job_of(const Stage& stage, const SolverEntry& entry, int round) {
  Job job = job_of(stage, entry);
  job.name += "." + std::to_string(round);
  job.round = round;
  return job;
}

Job job_of(const Stage& stage, const DatasetSpec& dataset) {
  return {dataset.name + "." + stage.name(), dataset.name, "\"" + dataset.name + "\"", nullptr, 0};
}

}  // namespace ertbench
