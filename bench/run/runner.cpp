#include "bench/run/runner.h"

#include <algorithm>

#include "bench/record/limit_file.h"
#include "bench/report/results.h"
#include "bench/run/builds.h"
#include "bench/run/datasets.h"
#include "bench/run/job_records.h"
#include "bench/run/job_runner.h"
#include "bench/run/one_go.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// --only names solvers: jobs that run none are always wanted.
bool is_wanted(const Job& job, const std::vector<std::string>& only) {
  return only.empty() || !job.entry ||
         std::any_of(only.begin(), only.end(), [&](const std::string& label) {
           return label == job.entry->label || label == job.entry->family;
         });
}

std::vector<Job> wanted(std::vector<Job> jobs, const std::vector<std::string>& only) {
  std::erase_if(jobs, [&](const Job& job) { return !is_wanted(job, only); });
  return jobs;
}

void forget(const Stages& stages, const Experiment& experiment, const Cache& cache,
            const RunOptions& options) {
  for (const std::unique_ptr<Stage>& stage : stages) {
    const JobRecords records(*stage, experiment, options.out);
    for (const Job& job : wanted(stage->jobs(experiment), options.only)) {
      fs::remove(records.file(job));
      stage->forget(experiment, cache, job);
    }
  }
}

/// Stage by stage: `work` sees to the records, then they are collected.
template <typename Work>
ExperimentResults gather(const Stages& stages, const Experiment& experiment, const Cache& cache,
                         const RunOptions& options, const Work& work) {
  ExperimentResults results;
  results.jobs = options.jobs;
  results.command = options.command;
  for (const std::unique_ptr<Stage>& stage : stages) {
    JobRecords records(*stage, experiment, options.out, cache.reuse());
    work(*stage, results, records);
    stage->collect(experiment, cache, records, results);
    add_builds(*stage, experiment, records, results);
    results.failures += records.failures();
  }
  if (!results.rows.empty()) {
    const DatasetSpec* training = experiment.training ? &*experiment.training : nullptr;
    add_limit_rows(options.out, {experiment.tests, training}, cache.reuse(), results.rows);
    compare_with_limits(options.out, results.frames, results.rows);
  }
  return results;
}

}  // namespace

ExperimentResults run_stages(const Stages& stages, const Experiment& experiment, const Cache& cache,
                             const RunOptions& options) {
  fs::create_directories(options.out / "records");
  if (options.fresh) forget(stages, experiment, cache, options);
  if (std::any_of(stages.begin(), stages.end(),
                  [](const auto& stage) { return stage->reads_datasets(); })) {
    ensure_datasets(experiment, cache);
  }
  return gather(stages, experiment, cache, options,
                [&](const Stage& stage, const ExperimentResults& results, JobRecords& records) {
                  const std::vector<Job> due = stage.due(experiment, results);
                  const OneGo go(stage, experiment, options.out, records, due,
                                 wanted(due, options.only));
                  JobRunner(stage, experiment, cache, options.out, records)
                      .run(go.jobs(), stage.wants_machine_alone() ? 1 : options.jobs);
                  if (records.failures() == 0) go.finish();
                });
}

ExperimentResults collect_stages(
    const Stages& stages, const Experiment& experiment, const Cache& cache,
    const RunOptions& options,
    const std::function<std::optional<Failure>(const Job& job)>& why_missing) {
  return gather(stages, experiment, cache, options,
                [&](const Stage& stage, const ExperimentResults& results, JobRecords& records) {
                  for (const Job& job : wanted(stage.due(experiment, results), options.only)) {
                    if (records.find(job).record) {
                      records.expect(job);
                    } else if (auto failure = why_missing(job)) {
                      records.add_failure(job, std::move(*failure));
                    }
                  }
                });
}

ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options) {
  return run_stages(stages_of_run(), experiment, cache, options);
}

std::vector<ReportSection> report_stages(const Stages& stages, const Experiment& experiment,
                                         const ExperimentResults& results, const fs::path& folder) {
  std::vector<ReportSection> sections;
  for (const std::unique_ptr<Stage>& stage : stages) {
    const std::vector<ReportSection> own = stage->report(experiment, results, folder);
    sections.insert(sections.end(), own.begin(), own.end());
  }
  return sections;
}

std::size_t report_experiment(const Experiment& experiment, const Cache& cache,
                              const ExperimentResults& results, const fs::path& folder) {
  const auto sections = report_stages(stages_of_run(), experiment, results, folder);
  return report_results(experiment, cache, results, sections, folder);
}

}  // namespace ertbench
