// Timing of the forward model.
//
//   build/release/benchmarks/forward_benchmark
//   build/release/benchmarks/forward_benchmark --benchmark_filter=training
//
// "Debug" in the header is how Debian's Google Benchmark was built; ertbench itself is a release.

#include <benchmark/benchmark.h>

#include <cmath>

#include "bench/benchmarks/benchmark_program.h"
#include "core/random.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/data/scene_distribution.h"
#include "forward/data/scene_model.h"
#include "forward/ellipses/ellipse_model.h"
#include "forward/fem/condensation.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

SceneDistribution training() { return {}; }

SceneDistribution table_c1() {
  SceneDistribution d;
  d.contacts = {1, 1};
  d.shapes = {DrawnShape::disc};
  d.radius = {0.2, 0.2};
  d.conductivity_ratio = {0.6, 0.6};
  return d;
}

std::vector<Scene> draw(const SceneDistribution& distribution, int count) {
  std::vector<Scene> scenes;
  for (int s = 0; s < count; ++s) {
    RandomStream random(1, 2, static_cast<std::uint64_t>(s), Purpose::scene);
    scenes.push_back(distribution.draw(random, *square_sheet()));
  }
  return scenes;
}

Images sheets(const SceneDistribution& distribution, int count, int grid) {
  const PixelGrid pixels = square_sheet()->pixels(grid);
  Images images(count, grid * grid);
  Eigen::VectorXd ratio(grid * grid);
  int row = 0;
  for (const Scene& scene : draw(distribution, count)) {
    rasterise(scene, pixels, Rasterisation::area, ratio);
    images.row(row++) = 0.06 * ratio;
  }
  return images;
}

void solve(benchmark::State& state, const SceneDistribution& distribution, ForwardMethod method) {
  const int grid = static_cast<int>(state.range(0));
  const int count = grid <= 48 ? 512 : 32;
  const ForwardModel model(Sensor{}, grid);
  const Images images = sheets(distribution, count, grid);
  for (auto _ : state) benchmark::DoNotOptimize(model.solve(images, method));
  state.SetItemsProcessed(state.iterations() * count);
}
/// Solves the border integral equation to a quarter of the noise of 50 dB.
void borders(benchmark::State& state, const SceneDistribution& distribution) {
  const BorderModel model{Sensor{}};
  const double tolerance = 0.25 * std::pow(10, -2.5) * model.reference_voltages().norm();
  const std::vector<Scene> scenes = draw(distribution, 512);
  for (auto _ : state) {
    for (const Scene& scene : scenes) benchmark::DoNotOptimize(model.solve(scene, tolerance));
  }
  state.SetItemsProcessed(state.iterations() * 512);
}
BENCHMARK_CAPTURE(borders, training, training())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(borders, table_c1, table_c1())->Unit(benchmark::kMillisecond);

/// One to four discs with voltages and all derivatives, at a hundredth part of the resolution
/// given, against the operations that it takes: the factorisation, two solves for all electrodes,
/// the kernels, and per contact the products of fields, which are symmetric, times its five
/// motions, and those for its ratio.
void ellipses(benchmark::State& state) {
  const auto contacts = static_cast<std::size_t>(state.range(0));
  const Sensor sensor;
  const EllipseModel model(sensor, {static_cast<double>(state.range(1)) / 100, 120});
  std::vector<EllipticContact> scene(contacts);
  for (std::size_t k = 0; k < contacts; ++k) {
    scene[k].centre = {k % 2 == 0 ? 0.45 : -0.45, k < 2 ? 0.45 : -0.45};
    scene[k].log_size = std::log(0.2);
    scene[k].log_ratio = std::log(0.6);
  }
  EllipseModel::Workspace workspace;
  Eigen::VectorXd change(model.pairs());
  Eigen::MatrixXd derivatives(model.pairs(),
                              EllipticContact::parameters * static_cast<Eigen::Index>(contacts));
  for (auto _ : state) {
    benchmark::DoNotOptimize(model.place(scene, workspace));
    model.evaluate(workspace, change);
    model.derivatives(workspace, derivatives);
  }
  const double points = workspace.points();
  const double each = points / static_cast<double>(contacts);
  const double electrodes = sensor.electrode_count;
  const double flop = 2.0 / 3 * points * points * points + 4 * points * points * electrodes +
                      20 * points * points + 30 * points * electrodes +
                      2 * points * electrodes * electrodes +
                      points * (2 * each * electrodes + 9 * electrodes * electrodes);
  state.counters["points"] = points;
  state.counters["flop"] = flop;
  compare_with_limit(state, flop / gemm_double_rate(), "gemm_double");
}
BENCHMARK(ellipses)
    ->ArgNames({"contacts", "resolution"})
    ->ArgsProduct({{1, 2, 3, 4}, {100, 140, 200, 400}})
    ->Unit(benchmark::kMicrosecond);

#define ERTBENCH_SOLVE(name, distribution, method)                      \
  BENCHMARK_CAPTURE(solve, name, distribution(), ForwardMethod::method) \
      ->Arg(24)                                                         \
      ->Arg(48)                                                         \
      ->Arg(96)                                                         \
      ->Arg(192)                                                        \
      ->Unit(benchmark::kMillisecond)
ERTBENCH_SOLVE(training_automatic, training, automatic);
ERTBENCH_SOLVE(training_condensation, training, condensation);
ERTBENCH_SOLVE(training_contact_update, training, contact_update);
ERTBENCH_SOLVE(table_c1_automatic, table_c1, automatic);
ERTBENCH_SOLVE(table_c1_condensation, table_c1, condensation);
ERTBENCH_SOLVE(table_c1_contact_update, table_c1, contact_update);

/// Break-even of the methods: one disc of growing radius (in thousandths), with its active nodes.
void disc(benchmark::State& state, ForwardMethod method) {
  const int grid = static_cast<int>(state.range(0));
  SceneDistribution d = table_c1();
  const double radius = static_cast<double>(state.range(1)) / 1000;
  d.radius = {radius, radius};
  const ForwardModel model(Sensor{}, grid);
  const Images images = sheets(d, 32, grid);
  const ContactUpdate update(grid, grid, electrode_nodes(Sensor{}, grid), drive_pairs(Sensor{}));
  double active = 0;
  for (Eigen::Index s = 0; s < images.rows(); ++s) {
    const Eigen::VectorXd ratio = images.row(s) / 0.06;
    active += static_cast<double>(update.active_nodes(ratio.data()).size()) / 32;
  }
  for (auto _ : state) benchmark::DoNotOptimize(model.solve(images, method));
  state.SetItemsProcessed(state.iterations() * images.rows());
  state.counters["active_nodes"] = active;
}
BENCHMARK_CAPTURE(disc, condensation, ForwardMethod::condensation)
    ->ArgsProduct({{24, 48, 96, 192}, {200}})
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(disc, contact_update, ForwardMethod::contact_update)
    ->ArgsProduct({{24, 48, 96, 192}, {60, 100, 200, 300, 400, 600, 900}})
    ->Unit(benchmark::kMillisecond);

void jacobian_at_background(benchmark::State& state) {
  const ForwardModel model(Sensor{}, 24);
  for (auto _ : state) benchmark::DoNotOptimize(model.jacobian());
}
BENCHMARK(jacobian_at_background)->Unit(benchmark::kMicrosecond);

void jacobian_at_an_image(benchmark::State& state) {
  const ForwardModel model(Sensor{}, static_cast<int>(state.range(0)));
  const Eigen::VectorXd image = sheets(training(), 1, model.grid()).row(0);
  for (auto _ : state) benchmark::DoNotOptimize(model.jacobian(image));
}
BENCHMARK(jacobian_at_an_image)->Arg(24)->Arg(48)->Unit(benchmark::kMicrosecond);

void rasterise_training(benchmark::State& state) {
  const int grid = static_cast<int>(state.range(0));
  const PixelGrid pixels = square_sheet()->pixels(grid);
  const std::vector<Scene> scenes = draw(training(), 512);
  Eigen::VectorXd ratio(grid * grid);
  for (auto _ : state) {
    for (const Scene& scene : scenes) rasterise(scene, pixels, Rasterisation::area, ratio);
    benchmark::DoNotOptimize(ratio.data());
  }
  state.SetItemsProcessed(state.iterations() * 512);
}
BENCHMARK(rasterise_training)->Arg(24)->Arg(48)->Arg(96)->Arg(192)->Unit(benchmark::kMillisecond);

constexpr int continuous = 0;  ///< in place of a grid

/// Computes one row of a dataset file on one core: scene, image, voltages and noise.
void generate_rows(benchmark::State& state) {
  DatasetSpec spec;
  spec.name = "train";
  spec.count = 1024;
  if (state.range(0) == continuous) {
    spec.model = ContinuousSheet{};
  } else {
    spec.model = GridSheet{static_cast<int>(state.range(0))};
  }
  spec.noise = {50, SnrBasis::absolute};
  spec.scenes = training();
  const SceneModel model(spec.sensor, spec.model);
  for (auto _ : state) benchmark::DoNotOptimize(generate_block(spec, model, 0, spec.count));
  state.SetItemsProcessed(state.iterations() * 1024);
}
BENCHMARK(generate_rows)
    ->Arg(24)
    ->Arg(48)
    ->Arg(96)
    ->Arg(continuous)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void prepare(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(ForwardModel(Sensor{}, static_cast<int>(state.range(0))));
  }
}
BENCHMARK(prepare)->Arg(24)->Arg(48)->Arg(96)->Arg(192)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) { return ertbench::run_benchmarks(argc, argv); }
