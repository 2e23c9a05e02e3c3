#include "bench/run/datasets.h"

#include <algorithm>
#include <thread>

#include "core/progress.h"
#include "forward/data/generate.h"

namespace ertbench {

void ensure_datasets(const Experiment& experiment, const Cache& cache) {
  namespace fs = std::filesystem;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  fs::create_directories(cache.folder() / "datasets");
  for (const DatasetSpec* spec : experiment.datasets()) {
    const fs::path file = cache.dataset(*spec);
    if (fs::exists(file)) continue;
    Progress progress("generating \"" + spec->name + "\" (" + std::to_string(spec->count) +
                      " scenes, grid " + text_of(spec->model) + ")");
    generate_dataset(*spec, file, {cores, [&](std::uint64_t done, std::uint64_t total) {
                                     progress.update(done, total);
                                   }});
  }
}

}  // namespace ertbench
