#pragma once

#include <filesystem>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// Writes the datasets that are missing from the cache, showing progress, and those that are not to
/// be reused (Cache::reuse), of which it says why. Warns of those with missed promises.
void ensure_datasets(const Experiment& experiment, const Cache& cache);

/// Warns on how many scenes of a dataset's file its model error is not kept, if there are any.
void warn_of_missed_promise(const DatasetSpec& spec, const std::filesystem::path& file);

/// Writes one dataset if it is missing or not to be reused, without showing progress.
void ensure_dataset(const DatasetSpec& spec, const Cache& cache, int threads);

}  // namespace ertbench
