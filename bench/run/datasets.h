#pragma once

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// Writes the datasets that are missing from the cache, showing progress, and those that are not to
/// be reused (Cache::reuse), of which it says why.
void ensure_datasets(const Experiment& experiment, const Cache& cache);

/// The same of one dataset, without showing progress.
void ensure_dataset(const DatasetSpec& spec, const Cache& cache, int threads);

}  // namespace ertbench
