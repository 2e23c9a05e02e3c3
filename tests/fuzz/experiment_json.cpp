// An experiment file: read and checked whole, then what a run does with each dataset first.

#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/record/cache.h"
#include "solvers/registry/registry.h"
#include "tests/fuzz/fuzz_input.h"

namespace ertbench {
namespace {

/// The names in the cache, and a scene of each dataset: drawing one must come to an end.
void begin_run(const Experiment& experiment) {
  const Cache cache("cache");
  for (const DatasetSpec* dataset : experiment.datasets()) {
    static_cast<void>(cache.dataset(*dataset));
    static_cast<void>(dataset->scene(dataset->count - 1));
  }
  for (const SolverEntry& entry : experiment.solvers) {
    static_cast<void>(cache.fitted_solver(fit_recipe(experiment, entry)));
  }
}

}  // namespace
}  // namespace ertbench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  static const ChartTypes charts = chart_types();
  const std::filesystem::path file = fuzzing::file_of(bytes, size, "experiment.json");
  SolverRegistry registry;
  std::optional<Experiment> experiment;
  const bool good = fuzzing::accepted(
      file.string(), [&] { experiment = read_experiment(file, registry, charts); });
  if (good) begin_run(*experiment);
  return 0;
}
