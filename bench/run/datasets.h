#pragma once

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// Writes the datasets that are missing from the cache, showing progress.
void ensure_datasets(const Experiment& experiment, const Cache& cache);

}  // namespace ertbench
