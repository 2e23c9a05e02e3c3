#include "bench/run/trial.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment_solvers.h"
#include "bench/record/record_file.h"
#include "bench/record/stamps.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/text.h"
#include "solvers/external/program.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

/// Fills in what the registration of the entry's type says, whose plugin this loads. What is wrong
/// with that the stage says, with the place in the file.
void describe_loaded(SolverEntry& entry, SolverRegistry& registry) {
  try {
    describe(entry, registry.load(entry.type));
  } catch (const InputError&) {
  }
}

}  // namespace

void run_trial(const Stage& stage, const std::string& name, Experiment& experiment,
               const Cache& cache, SolverRegistry& registry, int threads,
               const std::filesystem::path& folder) {
  const std::vector<Job> jobs = stage.jobs(experiment);
  const auto job =
      std::find_if(jobs.begin(), jobs.end(), [&](const Job& one) { return one.name == name; });
  if (job == jobs.end()) {
    throw InputError("--job: the stage " + stage.name() + " has no job \"" + printable(name) +
                     "\"");
  }
  registry.allow_plugins();  // this process is there for nothing else
  for (SolverEntry& entry : experiment.solvers) {
    if (&entry == job->entry) describe_loaded(entry, registry);
  }
  const JobContext context{experiment, cache, registry, threads,
                           record_file(folder, name, ".progress")};
  try {
    const nlohmann::json result = stage.run(*job, context);
    require_programs_ended_well();
    write_record(record_file(folder, name, written_ending), result, stage.key(experiment, *job),
                 stamp_of_record(experiment, job->entry));
  } catch (const FailedTrial& failed) {
    write_file_atomically(
        record_file(folder, name, failure_ending),
        json_text({{"status", failed.status()}, {"message", std::string(failed.what())}}));
    throw;
  }
}

}  // namespace ertbench
