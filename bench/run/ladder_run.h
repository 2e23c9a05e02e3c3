#pragma once

#include <filesystem>
#include <functional>

#include "bench/experiment/fit_recipe.h"
#include "bench/experiment/ladder_spec.h"
#include "bench/record/cache.h"
#include "bench/record/ladder_record.h"

namespace ertbench {

class SolverRegistry;

/// Takes the recipe's solver (from the cache, or fitted) up all ladders that concern it and judges
/// every frame. `base` is the test set that all levels are variants of. Levels are made in memory;
/// solvers of parameter axes and their training sets go to the cache.
LadderRecord climb_ladders(const FitRecipe& recipe, const Ladders& ladders, const DatasetSpec& base,
                           const Cache& cache, SolverRegistry& registry, int threads,
                           const std::filesystem::path& progress_file);

/// Evaluates the axis's own levels, then halves the step in which the share of failing frames first
/// exceeds `limit`: six times, or on an integer axis down to neighbouring numbers. Without an order
/// or of a parameter, the axis's own levels alone. Returns them from the mildest.
std::vector<LadderLevel> climb_ladder(
    const LadderAxis& axis, double limit,
    const std::function<LadderLevel(const Level& level)>& evaluate);

}  // namespace ertbench
