#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "bench/experiment/fit_recipe.h"
#include "bench/record/cache.h"
#include "solvers/solver.h"

namespace ertbench {

class SolverRegistry;

struct FittedSolver {
  std::unique_ptr<Solver> solver;
  double fit_s = 0;                      ///< what fitting took, now or in an earlier run
  std::optional<BuildStamp> build = {};  ///< the build that fitted it
};

/// The recipe's solver from the cache where it may be reused (Cache::reuse), or fitted and put
/// there: the file first, then its note, both renamed into place. Another process that fits the
/// same solver is waited for. While it is fitted its progress stands in `progress_file`. The
/// datasets must be in the cache.
FittedSolver fitted_solver(const FitRecipe& recipe, const Cache& cache, SolverRegistry& registry,
                           int threads, const std::filesystem::path& progress_file);

/// Removes it from the cache, with what the solver left there while it was fitted.
void forget_fitted_solver(const FitRecipe& recipe, const Cache& cache);

}  // namespace ertbench
