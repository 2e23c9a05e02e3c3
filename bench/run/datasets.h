#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "bench/experiment/experiment.h"
#include "bench/experiment/solver_entry.h"
#include "bench/record/cache.h"
#include "solvers/solver.h"

namespace ertbench {

/// Writes the datasets that are missing from the cache, showing progress, and those that are not to
/// be reused (Cache::reuse), of which it says why. Warns of those with missed promises.
void ensure_datasets(const Experiment& experiment, const Cache& cache);

/// Warns on how many scenes of a dataset's file its model error is not kept, if there are any.
void warn_of_missed_promise(const DatasetSpec& spec, const std::filesystem::path& file);

/// Writes one dataset if it is missing or not to be reused, without showing progress.
void ensure_dataset(const DatasetSpec& spec, const Cache& cache, int threads);

class SolverRegistry;

struct FittedSolver {
  std::unique_ptr<Solver> solver;
  /// What fitting took, now or in an earlier run; nothing if it was loaded from its "checkpoint".
  std::optional<double> fit_s;
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
