#include "bench/run/datasets.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/run/machine_load.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/process.h"
#include "core/progress.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/data/missed_promise.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// Why the file of a dataset is not to be taken as it is; empty where it may be. Reads all of it.
std::string why_not(const DatasetSpec& spec, const fs::path& file, Reuse reuse) {
  try {
    const DatasetFile set(file);
    if (set.recipe() != to_json(spec).dump()) return "it is another dataset than its name says";
    const std::string stale =
        why_stale(set.build(), stamp_of_this_build(this_build().data_code), reuse);
    return stale.empty() ? set.why_changed() : stale;
  } catch (const InputError& error) {
    return std::string("it cannot be read: ") + error.what();
  }
}

/// The same, found out in a child: the HDF5 library does not survive every damaged file.
std::string why_not_safely(const DatasetSpec& spec, const fs::path& file, Reuse reuse) {
  const IsolatedOutcome outcome =
      run_isolated([&](const auto& send) { send(why_not(spec, file, reuse)); },
                   {600, machine_memory_bytes() / 2});
  if (outcome.finished && !outcome.messages.empty()) return outcome.messages.front();
  return "it is damaged: the HDF5 library cannot get through it (" + outcome.end.text() + ")";
}

/// Whether the cache has the dataset; what is not to be reused there is removed, and said.
bool is_there(const DatasetSpec& spec, const Cache& cache) {
  const fs::path file = cache.dataset(spec);
  if (!fs::exists(file)) return false;
  const std::string why = why_not_safely(spec, file, cache.reuse());
  if (why.empty()) return true;
  spdlog::info("dataset \"{}\" is made again: {}", spec.name, why);
  fs::remove(file);
  return false;
}

}  // namespace

void ensure_datasets(const Experiment& experiment, const Cache& cache) {
  const int cores = usable_cores();
  fs::create_directories(cache.folder() / "datasets");
  for (const DatasetSpec* spec : experiment.datasets()) {
    if (is_there(*spec, cache)) {
      warn_of_missed_promise(*spec, cache.dataset(*spec));
      continue;
    }
    Progress progress("generating \"" + spec->name + "\" (" + std::to_string(spec->count) +
                      " scenes, grid " + text_of(spec->model) + ")");
    generate_dataset(
        *spec, cache.dataset(*spec),
        {cores, [&](std::uint64_t done, std::uint64_t total) { progress.update(done, total); }});
    warn_of_missed_promise(*spec, cache.dataset(*spec));
  }
}

void warn_of_missed_promise(const DatasetSpec& spec, const fs::path& file) {
  const std::string missed = missed_promise(spec, DatasetFile(file)).sentence();
  if (!missed.empty()) spdlog::warn("{}: {}", spec.name, missed);
}

void ensure_dataset(const DatasetSpec& spec, const Cache& cache, int threads) {
  if (!is_there(spec, cache)) generate_dataset(spec, cache.dataset(spec), {threads, {}});
}

}  // namespace ertbench
