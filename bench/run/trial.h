#pragma once

#include <filesystem>
#include <string>

#include "bench/run/stage.h"

namespace ertbench {

/// What `ertbench trial` does, in a process of its own: runs the stage's job of this name and
/// writes its record into the result folder; meanwhile its progress stands beside it. Throws
/// InputError where the stage has no such job.
void run_trial(const Stage& stage, const std::string& job, const Experiment& experiment,
               const Cache& cache, SolverRegistry& registry, int threads,
               const std::filesystem::path& folder);

}  // namespace ertbench
