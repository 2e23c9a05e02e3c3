#include "bench/run/fidelity_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/record/fidelity_record.h"
#include "bench/record/progress_file.h"
#include "bench/report/fidelity_report.h"
#include "bench/run/fidelity.h"
#include "bench/run/job_records.h"

namespace ertbench {
namespace {

constexpr double scenes_of_one_limit = 500;

const DatasetSpec& dataset_of(const Experiment& experiment, const Job& job) {
  return *experiment.find_dataset(job.subject);
}

}  // namespace

std::string FidelityStage::name() const { return "fidelity"; }

std::string FidelityStage::noun() const { return "dataset"; }

double FidelityStage::time_limit_s(const Experiment& experiment) const {
  // The limit is meant for a trial; who asks for more scenes than usual means them to be done.
  return experiment.time_limit_s * std::max(1.0, scenes_ / scenes_of_one_limit);
}

std::vector<std::string> FidelityStage::options() const {
  return {"--scenes=" + std::to_string(scenes_)};
}

std::vector<Job> FidelityStage::jobs(const Experiment& experiment) const {
  std::vector<Job> jobs;
  for (const DatasetSpec* dataset : experiment.datasets()) {
    if (!dataset->measured()) jobs.push_back(job_of(*this, *dataset));
  }
  return jobs;
}

std::vector<Job> FidelityStage::due(const Experiment& experiment, const ExperimentResults&) const {
  return jobs(experiment);
}

std::string FidelityStage::key(const Experiment& experiment, const Job& job) const {
  return fidelity_key(dataset_of(experiment, job), scenes_);
}

nlohmann::json FidelityStage::run(const Job& job, const JobContext& context) const {
  ProgressFile progress(context.progress_file);
  return to_json(measure_fidelity(
      dataset_of(context.experiment, job), scenes_,
      [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total, ""); }));
}

void FidelityStage::check(const Experiment&, const nlohmann::json& record) const {
  fidelity_record_from_json(record);
}

void FidelityStage::collect(const Experiment& experiment, const Cache&, const JobRecords& records,
                            ExperimentResults& results) const {
  for (const DatasetSpec* dataset : experiment.datasets()) {
    if (dataset->measured()) continue;  // there is nothing to compare models on
    const Job job = job_of(*this, *dataset);
    FidelityOutcome& outcome = results.fidelity.emplace_back();
    outcome.dataset = dataset->name;
    if (const auto record = records.read(job)) {
      outcome.rows = fidelity_rows(*dataset, fidelity_record_from_json(*record));
    } else {
      outcome.failure = records.why_missing(job).text();
    }
  }
}

std::vector<ReportSection> FidelityStage::report(const Experiment& experiment,
                                                 const ExperimentResults& results,
                                                 const std::filesystem::path& folder) const {
  report_fidelity(experiment, results.fidelity, results.builds, folder);
  return {};
}

}  // namespace ertbench
