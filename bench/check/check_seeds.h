#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "bench/record/cache.h"
#include "bench/record/result_row.h"
#include "bench/run/runner.h"

namespace ertbench {

/// Trains the solvers of `labels` with `count` seeds each and gives their `rows` the means, the
/// seeds and, where a training failed, the status that came out; rows that have as many seeds
/// already stay as they are. The seeds are those of the experiment, filled up with the smallest
/// numbers from 1 that it does not have. Runs the experiment with just these solvers, with "seeds"
/// in place of "seed" and without timing, into `options.out`/seeds; what was trained before is
/// taken from the cache. Returns how many trials failed.
int train_over_seeds(const Experiment& experiment, const std::set<std::string>& labels, int count,
                     const Cache& cache, const RunOptions& options, std::vector<ResultRow>& rows);

/// What makes that of the experiment (apply_overrides): the rows of `labels` over seeds, and all
/// else as it is that their scores depend on.
std::vector<std::string> overrides_for_seeds(const Experiment& experiment,
                                             const std::set<std::string>& labels, int count);

/// The rows in a result folder's summary.json. Throws InputError.
std::vector<ResultRow> read_summary_rows(const std::filesystem::path& folder);

}  // namespace ertbench
