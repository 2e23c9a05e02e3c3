#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "bench/record/result_row.h"

namespace ertbench {

/// The file beside an experiment's results that `ertbench limit` writes.
inline constexpr const char* limit_file = "limit.json";

/// Types and labels of the rows in it: under the prior of the test set's own scenes, and under that
/// of the training set's. Reference rows like "truth": no solver has them.
inline constexpr const char* limit_oracle = "limit-oracle";
inline constexpr const char* limit_fair = "limit-fair";

bool is_limit(const ResultRow& row);

/// The rows of the file in a folder of results; none where there is no file. Throws InputError for
/// a file that is none of this kind.
std::vector<ResultRow> read_limit_rows(const std::filesystem::path& folder);

/// The row that nothing can be better than: that of the oracle; null where there is none.
const ResultRow* limit_of(std::span<const ResultRow> rows, const std::string& dataset);

}  // namespace ertbench
