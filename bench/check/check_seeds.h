#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
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
/// numbers from 1 that it does not have. Runs a copy of the experiment that holds just these
/// solvers, with "seeds" in place of "seed" and without timing, which stays as
/// `options.out`/seeds/NAME.json beside its own results; what was trained before is taken from the
/// cache. Returns how many trials failed.
int train_over_seeds(const Experiment& experiment, const std::set<std::string>& labels, int count,
                     const Cache& cache, const RunOptions& options, std::vector<ResultRow>& rows);

/// The copy that these are trained by: the rows of `labels` over seeds, and all else that their
/// scores depend on. Files that it names are absolute, so that it may stand anywhere.
nlohmann::json experiment_over_seeds(const Experiment& experiment,
                                     const std::set<std::string>& labels, int count);

/// The rows in a result folder's summary.json. Throws InputError.
std::vector<ResultRow> read_summary_rows(const std::filesystem::path& folder);

}  // namespace ertbench
