#include "bench/run/trial.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/record/record_file.h"
#include "core/errors.h"

namespace ertbench {

void run_trial(const Stage& stage, const std::string& name, const Experiment& experiment,
               const Cache& cache, SolverRegistry& registry, int threads,
               const std::filesystem::path& folder) {
  const std::vector<Job> jobs = stage.jobs(experiment);
  const auto job =
      std::find_if(jobs.begin(), jobs.end(), [&](const Job& one) { return one.name == name; });
  if (job == jobs.end()) {
    throw InputError("--job: the stage " + stage.name() + " has no job \"" + name + "\"");
  }
  const JobContext context{experiment, cache, registry, threads,
                           record_file(folder, name, ".progress")};
  write_record(record_file(folder, name), stage.run(*job, context), stage.key(experiment, *job));
}

}  // namespace ertbench
