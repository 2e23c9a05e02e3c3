#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/ladder_record.h"

namespace ertbench {

class SolverRegistry;

/// Takes the entry's fitted solver (or fits it) up all ladders that concern it, judges every frame
/// and writes the ladders' record into `folder`; meanwhile its progress stands beside it. Levels
/// are made in memory; solvers of parameter axes and their training sets go to the cache.
void run_ladder_stage(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                      SolverRegistry& registry, int threads, const std::filesystem::path& folder);

/// Evaluates the axis's own levels, then halves the step in which the share of failing frames first
/// exceeds `limit`: six times, or on an integer axis down to neighbouring numbers. Without an order
/// or of a parameter, the axis's own levels alone. Returns them from the mildest.
std::vector<LadderLevel> climb_ladder(
    const LadderAxis& axis, double limit,
    const std::function<LadderLevel(const Level& level)>& evaluate);

}  // namespace ertbench
