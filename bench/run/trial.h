#pragma once

#include <filesystem>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

class SolverRegistry;

/// Fits the solver (or takes it from the cache), reconstructs every test set, scores each frame and
/// writes the accuracy record into `folder`; while it fits, its progress stands beside the record.
/// Datasets must be in the cache.
void run_accuracy_stage(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                        SolverRegistry& registry, int threads, const std::filesystem::path& folder);

/// Times the fitted solver on the round's share of every test set, one frame at a time on one
/// thread, then on batches, and writes the round's record.
void run_timing_round(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                      SolverRegistry& registry, int round, const std::filesystem::path& folder);

}  // namespace ertbench
