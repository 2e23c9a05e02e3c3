#include "bench/run/trial.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment_solvers.h"
#include "bench/record/record_file.h"
#include "core/errors.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {

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
  for (SolverEntry& entry : experiment.solvers) {
    if (&entry != job->entry) continue;
    if (const SolverInfo* info = registry.find(entry.type)) describe(entry, *info);
  }
  const JobContext context{experiment, cache, registry, threads,
                           record_file(folder, name, ".progress")};
  write_record(record_file(folder, name), stage.run(*job, context), stage.key(experiment, *job),
               stamp_of_records(experiment.plugins));
}

}  // namespace ertbench
