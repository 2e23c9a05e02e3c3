// Timing of the classical solvers, single-threaded.
//
//   build/release/benchmarks/solvers_benchmark
//   build/release/benchmarks/solvers_benchmark --benchmark_filter='/1$|Stream'
//
// The frames are random discs (radius 0.2, 0.6 of the background) with 50 dB noise on the absolute
// voltages. `Reconstruct/<solver>/<batch>`: items are frames; batch 1 is the latency, and walks
// through the frames one by one. `StreamMatrix` reads once as many numbers as the linear solvers'
// matrix holds: the least that a matrix-vector product can cost.
// "Debug" in the header is how Debian's Google Benchmark was built; ertbench itself is a release.

#include <benchmark/benchmark.h>

#include <map>
#include <nlohmann/json.hpp>

#include "forward/dataset_spec.h"
#include "forward/forward_model.h"
#include "forward/generate.h"
#include "forward/json_reader.h"
#include "solvers/interior_point.h"
#include "solvers/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr Eigen::Index most_frames = 1024;

const Frames& frames() {
  static const Frames changes = [] {
    const json spec = {
        {"count", most_frames},
        {"seed", 1},
        {"grid", 24},
        {"snr_db", 50},
        {"snr_basis", "absolute"},
        {"scenes",
         {{"contacts", 1}, {"shapes", {"disc"}}, {"radius", 0.2}, {"conductivity_ratio", 0.6}}}};
    const ForwardModel model(Sensor{}, 24);
    const DatasetSpec dataset =
        dataset_spec_from_json(JsonObject(spec, "benchmark", ""), Sensor{}, "benchmark");
    Frames voltages = generate_block(dataset, model, 0, most_frames).voltages;
    voltages.rowwise() -= model.reference_voltages().transpose();
    return voltages;
  }();
  return changes;
}

const std::map<std::string, json>& specs() {
  static const std::map<std::string, json> all = {
      {"one-step-gn", {{"type", "one-step-gn"}, {"lambda", 0.1}}},
      {"tsvd", {{"type", "tsvd"}, {"rank", 45}}},
      {"pdipm", {{"type", "pdipm"}, {"alpha", 1e-5}}}};
  return all;
}

std::unique_ptr<Solver> make(const std::string& name) {
  return SolverRegistry().make(JsonObject(specs().at(name), "benchmark", ""));
}

void reconstruct(benchmark::State& state, const std::string& name) {
  const std::unique_ptr<Solver> solver = make(name);
  FitInput input;
  solver->fit(input);
  const Eigen::Index batch = state.range(0);
  Images images(batch, input.sensor.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(batch));
  Eigen::Index first = 0;
  double iterations = 0;
  for (auto _ : state) {
    solver->reconstruct(frames().middleRows(first, batch), images, reports);
    benchmark::DoNotOptimize(images.data());
    benchmark::ClobberMemory();
    first = (first + batch) % most_frames;
    for (const FrameReport& report : reports) iterations += report.iterations;
  }
  const auto items = static_cast<double>(state.iterations() * batch);
  state.SetItemsProcessed(state.iterations() * batch);
  if (iterations > 0) state.counters["newton_steps"] = iterations / items;
}

void fit(benchmark::State& state, const std::string& name) {
  for (auto _ : state) {
    const std::unique_ptr<Solver> solver = make(name);
    solver->fit(FitInput{});
  }
}

/// Reads a matrix of the size of the linear solvers', adding its numbers up.
void stream_matrix(benchmark::State& state) {
  const Sensor sensor;
  const Eigen::VectorXd matrix =
      Eigen::VectorXd::Ones(Eigen::Index{sensor.pixels()} * sensor.channels() / 2);
  for (auto _ : state) benchmark::DoNotOptimize(matrix.sum());
  state.SetBytesProcessed(state.iterations() * matrix.size() *
                          static_cast<std::int64_t>(sizeof(double)));
}
BENCHMARK(stream_matrix)->Name("StreamMatrix");

/// Where a Newton step of PDIPM spends its time: the factorisation with this many channels.
void newton_factor(benchmark::State& state) {
  const TotalVariation problem{Sensor{}};
  NewtonSystem system(problem);
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(problem.edges().count());
  for (auto _ : state) benchmark::DoNotOptimize(system.factor(weights, state.range(0)));
}
BENCHMARK(newton_factor)->Name("Newton/Factor")->Arg(64)->Arg(112);

void newton_solve(benchmark::State& state) {
  const TotalVariation problem{Sensor{}};
  NewtonSystem system(problem);
  system.factor(Eigen::VectorXd::Ones(problem.edges().count()), state.range(0));
  const Eigen::VectorXd right = Eigen::VectorXd::Ones(problem.edges().pixels());
  Eigen::VectorXd x(right.size());
  for (auto _ : state) {
    system.solve(right, x);
    benchmark::DoNotOptimize(x.data());
  }
}
BENCHMARK(newton_solve)->Name("Newton/Solve")->Arg(64)->Arg(112);

void band_factor(benchmark::State& state) {
  const PixelEdges edges(24);
  GridLaplacian laplacian(24);
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(edges.count());
  for (auto _ : state) {
    laplacian.factor(edges, weights);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(band_factor)->Name("Newton/BandFactor");

void band_half_solve(benchmark::State& state) {
  const PixelEdges edges(24);
  GridLaplacian laplacian(24);
  laplacian.factor(edges, Eigen::VectorXd::Ones(edges.count()));
  const RowMajorMatrix right = RowMajorMatrix::Ones(edges.pixels(), state.range(0));
  RowMajorMatrix out(edges.pixels(), state.range(0));
  for (auto _ : state) {
    laplacian.half_solve(right, state.range(0), out);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(band_half_solve)->Name("Newton/BandHalfSolve")->Arg(64)->Arg(112);

const bool registered = [] {
  for (const auto& [name, spec] : specs()) {
    auto* const run =
        benchmark::RegisterBenchmark(("Reconstruct/" + name).c_str(), reconstruct, name);
    for (const int batch : {1, 16, 256, 1024}) run->Arg(batch);
    benchmark::RegisterBenchmark(("Fit/" + name).c_str(), fit, name)->Unit(benchmark::kMillisecond);
  }
  return true;
}();

}  // namespace
}  // namespace ertbench
