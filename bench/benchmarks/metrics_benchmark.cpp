// Timing of the scoring: the metrics of an image, and their bootstrap over a test set.
//
//   build/release/benchmarks/metrics_benchmark
//
// The images are what one-step Gauss-Newton makes of random contacts; items are frames.
// "Debug" in the header is how Debian's Google Benchmark was built; ertbench itself is a release.

#include <benchmark/benchmark.h>

#include <nlohmann/json.hpp>

#include "bench/benchmarks/benchmark_program.h"
#include "bench/score/metrics.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/scene_model.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct TestSet {
  Sensor sensor;
  std::vector<Scene> scenes;
  Images truths;   ///< [frames, pixels] S/m
  Images changes;  ///< [frames, pixels] S/m, reconstructed
};

const TestSet& test_set() {
  static const TestSet made = [] {
    DatasetSpec spec;
    spec.name = "test";
    spec.count = 1000;
    spec.noise = {50, SnrBasis::absolute};
    spec.scenes = SceneDistribution{};
    const SceneModel model(spec.sensor, spec.model);
    DatasetBlock block = generate_block(spec, model, 0, spec.count);
    block.voltages.rowwise() -= model.reference_voltages().transpose();

    const nlohmann::json gauss_newton = {{"type", "one-step-gn"}, {"lambda", 0.1}};
    const auto solver = SolverRegistry().make(JsonObject(gauss_newton, "benchmark", ""));
    solver->fit(FitInput{});
    TestSet out;
    for (std::uint64_t i = 0; i < spec.count; ++i) out.scenes.push_back(spec.scene(i));
    out.truths = block.conductivity;
    out.changes.resize(out.truths.rows(), out.truths.cols());
    std::vector<FrameReport> reports(out.scenes.size());
    solver->reconstruct(block.voltages, out.changes, reports);
    return out;
  }();
  return made;
}

std::vector<FrameMetrics> score(const TestSet& set) {
  std::vector<FrameMetrics> frames;
  for (std::size_t i = 0; i < set.scenes.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    frames.push_back(
        frame_metrics(set.sensor, set.truths.row(row), set.changes.row(row), set.scenes[i]));
  }
  return frames;
}

void metrics_of_frames(benchmark::State& state) {
  const TestSet& set = test_set();
  for (auto _ : state) benchmark::DoNotOptimize(score(set));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(set.scenes.size()));
}
BENCHMARK(metrics_of_frames)->Name("metrics/frames")->Unit(benchmark::kMillisecond);

/// Means, medians and intervals of all metrics over a test set of so many frames.
void bootstrap(benchmark::State& state) {
  std::vector<FrameMetrics> frames = score(test_set());
  frames.resize(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(summarise(frames));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(bootstrap)->Name("metrics/bootstrap")->Arg(100)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) { return ertbench::run_benchmarks(argc, argv); }
