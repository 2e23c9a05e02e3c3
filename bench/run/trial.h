#pragma once

#include <filesystem>
#include <string>

#include "bench/run/stage.h"

namespace ertbench {

/// Does the work of `ertbench trial` in a process of its own: runs the stage's job of this name and
/// writes its record into the result folder; meanwhile its progress stands beside it. Throws
/// InputError where the stage has no such job. The entry of the job's solver is described
/// (experiment_solvers.h); those of the others need not be, and their plugins are not loaded.
void run_trial(const Stage& stage, const std::string& job, Experiment& experiment,
               const Cache& cache, SolverRegistry& registry, int threads,
               const std::filesystem::path& folder);

}  // namespace ertbench
