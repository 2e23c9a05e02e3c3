#pragma once

#include "bench/cache.h"
#include "bench/experiment.h"

namespace ertbench {

/// Writes the datasets that are missing from the cache, showing progress.
void ensure_datasets(const Experiment& experiment, const Cache& cache);

}  // namespace ertbench
