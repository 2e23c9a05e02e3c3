#include "bench/run/ladder_stage.h"

#include <nlohmann/json.hpp>

#include "bench/report/ladder_report.h"
#include "bench/run/job_records.h"
#include "bench/run/ladder_run.h"

namespace ertbench {
namespace {

const DatasetSpec& base_of(const Experiment& experiment) {
  return *experiment.find_dataset(experiment.ladders->dataset);
}

}  // namespace

std::string LadderStage::name() const { return "ladders"; }

std::string LadderStage::noun() const { return "trial"; }

std::vector<Job> LadderStage::jobs(const Experiment& experiment) const {
  std::vector<Job> jobs;
  for (const SolverEntry& entry : experiment.solvers) jobs.push_back(job_of(*this, entry));
  return jobs;
}

std::vector<Job> LadderStage::due(const Experiment& experiment,
                                  const ExperimentResults& results) const {
  if (!experiment.ladders) return {};
  std::vector<Job> due = jobs(experiment);
  std::erase_if(
      due, [&](const Job& job) { return results.labels.at(job.entry->label).scored != job.entry; });
  return due;
}

std::string LadderStage::key(const Experiment& experiment, const Job& job) const {
  return ladder_key(fit_recipe(experiment, *job.entry), *experiment.ladders, base_of(experiment));
}

nlohmann::json LadderStage::run(const Job& job, const JobContext& context) const {
  const Experiment& experiment = context.experiment;
  return to_json(climb_ladders(fit_recipe(experiment, *job.entry), *experiment.ladders,
                               base_of(experiment), context.cache, context.registry,
                               context.threads, context.progress_file));
}

void LadderStage::check(const Experiment&, const nlohmann::json& record) const {
  ladder_record_from_json(record);
}

void LadderStage::collect(const Experiment& experiment, const Cache&, const JobRecords& records,
                          ExperimentResults& results) const {
  if (!experiment.ladders) return;
  for (const std::span<const SolverEntry> entries : experiment.rows()) {
    const LabelOutcome& label = results.labels.at(entries.front().label);
    LadderOutcome& outcome = results.ladders.emplace_back();
    outcome.entry = label.scored ? label.scored : &entries.front();
    outcome.failure = label.failure;
    if (!label.scored) continue;
    const Job job = job_of(*this, *label.scored);
    if (const auto record = records.read(job)) {
      outcome.record = ladder_record_from_json(*record);
    } else {
      outcome.failure = records.why_missing(job).text();
    }
  }
}

std::vector<ReportSection> LadderStage::report(const Experiment& experiment,
                                               const ExperimentResults& results,
                                               const std::filesystem::path& folder) const {
  return write_ladder_results(experiment, results.ladders, results.builds, folder);
}

}  // namespace ertbench
