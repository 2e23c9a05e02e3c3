#pragma once

#include <optional>

#include "bench/experiment/published_table.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// What the paper gives for this row, where it is compared on the row's test set.
std::optional<double> published_value(const PublishedTable& published, const ResultRow& row,
                                      Metric metric);

}  // namespace ertbench
