#pragma once

#include <span>
#include <vector>

#include "bench/record/cache.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// The rows that need no solver: the true images themselves, scored like any other, and the image
/// of an untouched sheet.
std::vector<ResultRow> reference_rows(const Sensor& sensor, std::span<const DatasetSpec> tests,
                                      const Cache& cache);

}  // namespace ertbench
