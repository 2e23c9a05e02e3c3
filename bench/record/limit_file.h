#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bench/record/experiment_results.h"
#include "bench/record/record_file.h"
#include "bench/record/result_row.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// The file beside an experiment's results that `ertbench limit` writes.
inline constexpr const char* limit_file = "limit.json";

/// Types and labels of the rows in it: under the prior of the test set's own scenes, and under that
/// of the training set's; and the lower bound under the first. Reference rows like "truth": no
/// solver has them.
inline constexpr const char* limit_oracle = "limit-oracle";
inline constexpr const char* limit_fair = "limit-fair";
inline constexpr const char* limit_lower = "limit-lower";

bool is_limit(const ResultRow& row);

/// The rows of the file in a folder of results; none where there is no file. Throws InputError for
/// a file that is none of this kind.
std::vector<ResultRow> read_limit_rows(const std::filesystem::path& folder);

/// Identifies the frames of a row of limits: a hash of all that determines the set's frames, and of
/// the distribution of `scenes`, a set's, that is the prior.
std::string limit_key(const DatasetSpec& set, const DatasetSpec& scenes);

/// The test sets that limits are of, and the training set, or null.
struct LimitSets {
  std::span<const DatasetSpec> tests;
  const DatasetSpec* training = nullptr;
};

/// Puts the limits in a folder of results behind the other reference rows of their sets. Those of
/// other sets or another prior than these, and those that may not be reused, are left out with a
/// warning.
void add_limit_rows(const std::filesystem::path& folder, const LimitSets& sets, Reuse reuse,
                    std::vector<ResultRow>& rows);

/// Sets ResultRow::over_limit of the rows whose frames were scored, `sets`, by the limits in a
/// folder of results of which `rows` has the rows.
void compare_with_limits(const std::filesystem::path& folder, std::span<const ScoredLabels> sets,
                         std::vector<ResultRow>& rows);

/// The row of the best known estimates, those of the oracle; null where there is none.
const ResultRow* limit_of(std::span<const ResultRow> rows, const std::string& dataset);

}  // namespace ertbench
