#include "bench/cluster/element.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/features/features.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "bench/run/runner.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

void note_failures(const JobRecords& records, const std::vector<Job>& jobs) {
  for (const Job& job : jobs) {
    const fs::path note = records.file(job, failed_ending);
    const Failure* failure = records.failure(job);
    if (!failure) {
      fs::remove(note);
      continue;
    }
    write_file_atomically(note, json_text(json{{"status", failure->status},
                                               {"message", failure->message},
                                               {"node", host_name()},
                                               {"date", utc_now()}},
                                          2));
  }
}

/// The failure that the job's element noted, or that it noted none.
Failure why_missing(const fs::path& note) {
  if (!fs::exists(note)) {
    return {"lost", "its element of the array ended without a record; give the same command again"};
  }
  try {
    const json content = read_json_file(note);
    return {content.at("status").get<std::string>(),
            content.at("message").get<std::string>() + " (on " +
                content.at("node").get<std::string>() + ")"};
  } catch (const std::exception& error) {
    return {"failed", error.what()};
  }
}

int make_datasets(const Experiment& experiment, const Cache& cache, const ElementOptions& options) {
  fs::create_directories(cache.folder() / "datasets");
  for (const std::string& name : options.units) {
    const DatasetSpec* spec = experiment.find_dataset(name);
    if (!spec) throw InputError("the experiment has no dataset \"" + printable(name) + "\"");
    ensure_dataset(*spec, cache, options.threads);
  }
  return 0;
}

int make_report(const Experiment& experiment, const Cache& cache, const ElementOptions& options) {
  RunOptions run;
  run.out = options.out;
  run.only = options.only;
  run.command = options.command;
  const Stages stages = stages_of_run(experiment, Machines::any);
  const ExperimentResults results =
      collect_stages(stages, experiment, cache, run, [&](const Job& job) -> std::optional<Failure> {
        return why_missing(record_file(options.out, job.name, failed_ending));
      });
  const std::size_t undrawn = report_experiment(experiment, cache, results, options.out);
  write_file_atomically(options.out / "slurm" / "outcome.json",
                        json_text(json{{"failures", results.failures}, {"undrawn", undrawn}}));
  return results.failures + static_cast<int>(undrawn);
}

}  // namespace

int run_element(const Experiment& experiment, const Cache& cache, const ElementOptions& options) {
  fs::create_directories(options.out / "records");
  if (options.part == "datasets") return make_datasets(experiment, cache, options);
  if (options.part == "report") return make_report(experiment, cache, options);
  const Experiment own = restricted_to(experiment, options.units);
  ExperimentResults results;
  for (const std::unique_ptr<Stage>& stage : stages_of_run(own, Machines::any)) {
    JobRecords records(*stage, own, options.out, cache.reuse());
    if (stage->name() == options.part) {
      const TimingSession session(*stage, own, options.out, records, stage->due(own, results),
                                  stage->due(own, results));
      JobRunner runner(*stage, own, cache, options.out, records);
      runner.take_only(options.threads);
      runner.run(session.jobs(), 1);
      if (records.failures() == 0) session.finish();
      note_failures(records, session.jobs());
      return records.failures();
    }
    stage->collect(own, cache, records, results);
  }
  throw InputError("--part: no stage is called \"" + printable(options.part) + "\"");
}

}  // namespace ertbench
