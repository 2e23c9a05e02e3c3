#pragma once

#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// The rows that need no solver: the true images themselves, scored like any other, and the image
/// of an untouched sheet.
std::vector<ResultRow> reference_rows(const Experiment& experiment, const Cache& cache);

}  // namespace ertbench
