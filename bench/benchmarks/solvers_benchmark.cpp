// Timing of the classical solvers, single-threaded.
//
//   build/release/benchmarks/solvers_benchmark
//   build/release/benchmarks/solvers_benchmark --benchmark_filter='/1$|limit'
//
// The frames are random discs (radius 0.2, 0.6 of the background) with 50 dB noise on the absolute
// voltages. `reconstruct/<solver>/<batch>`: items are frames; batch 1 is the latency, and walks
// through the frames one by one. benchmark_program.h explains the counters limit_us and of_limit,
// which are given where the arithmetic or the reading of matrices can be counted.
// "Debug" in the header is how Debian's Google Benchmark was built; ertbench itself is a release.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bench/benchmarks/benchmark_program.h"
#include "core/files.h"
#include "core/json.h"
#include "core/random.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/generate.h"
#include "forward/data/scene_model.h"
#include "forward/ellipses/ellipse_model.h"
#include "solvers/contacts/contact_fit.h"
#include "solvers/contacts/contact_prior.h"
#include "solvers/front/front.h"
#include "solvers/registry/registry.h"
#include "solvers/total_variation/interior_point.h"

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
    const SceneModel model(Sensor{}, GridSheet{24});
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
      {"pdipm", {{"type", "pdipm"}, {"alpha", 1e-5}}},
      {"one-step-gn-unchecked",
       {{"type", "one-step-gn"}, {"lambda", 0.1}, {"inference_check", false}}}};
  return all;
}

/// The set on which the frame check is fitted.
const DatasetFile& validation() {
  static const TemporaryFolder folder("solvers_benchmark");
  static const DatasetFile file = [] {
    const json spec = {{"count", 400},
                       {"seed", 2},
                       {"snr_db", 50},
                       {"snr_basis", "absolute"},
                       {"scenes", json::object()}};
    generate_dataset(
        dataset_spec_from_json(JsonObject(spec, "benchmark", ""), Sensor{}, "validation"),
        folder.path() / "validation.h5");
    return DatasetFile(folder.path() / "validation.h5");
  }();
  return file;
}

std::unique_ptr<Solver> make(const std::string& name) {
  return SolverRegistry().make(JsonObject(specs().at(name), "benchmark", ""));
}

/// Size of a linear solver's matrix, with a column for each reciprocal pair of channels, or of its
/// two factors of its rank if these are smaller.
std::int64_t matrix_numbers(const std::string& name) {
  const Sensor sensor;
  const std::int64_t pairs = sensor.channels() / 2;
  const std::int64_t rank = specs().at(name).value("rank", pairs);
  return std::min(sensor.pixels() * pairs, rank * (sensor.pixels() + pairs));
}

std::int64_t matrix_bytes(const std::string& name) {
  return matrix_numbers(name) * static_cast<std::int64_t>(sizeof(double));
}

void compare_linear(benchmark::State& state, const std::string& name, Eigen::Index batch) {
  if (batch == 1) {
    compare_with_limit(state, streaming_time(matrix_bytes(name)), "stream");
  } else {
    const double flops = 2 * static_cast<double>(matrix_numbers(name) * batch);
    compare_with_limit(state, flops / gemm_double_rate(), "gemm_double");
  }
}

/// Operations of the factorisation of a Newton system: the band, the half solves, G^T G (of which
/// one triangle is computed) and the dense factor.
double newton_factor_flops(double channels) {
  const double band = 24;
  const double unknowns = 24 * 24 - 1;
  return unknowns * band * band + 2 * unknowns * band * channels + unknowns * channels * channels +
         channels * channels * channels / 3;
}

/// Operations of one solve: both halves of the band, the products with G and G^T, the dense factor.
double newton_solve_flops(double channels) {
  const double band = 24;
  const double unknowns = 24 * 24 - 1;
  return 4 * unknowns * band + 4 * unknowns * channels + 2 * channels * channels;
}

/// Channels that count for these frames; the others add less than 1 % to the weight of any edge.
constexpr double useful_channels = 64;

void reconstruct(benchmark::State& state, const std::string& name) {
  const std::unique_ptr<Solver> solver = make(name);
  FitInput input;
  input.validation = &validation();
  solver->fit(input);
  const Eigen::Index batch = state.range(0);
  Images images(batch, input.sensor.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(batch));
  Eigen::Index first = 0;
  double iterations = 0;
  for (auto _ : state) {
    std::ranges::fill(reports, FrameReport{});
    solver->reconstruct(frames().middleRows(first, batch), images, reports);
    benchmark::DoNotOptimize(images.data());
    benchmark::ClobberMemory();
    first = (first + batch) % most_frames;
    for (const FrameReport& report : reports) iterations += report.iterations;
  }
  const auto items = static_cast<double>(state.iterations() * batch);
  state.SetItemsProcessed(state.iterations() * batch);
  if (iterations > 0) {
    state.counters["newton_steps"] = iterations / items;
    const double flops = newton_factor_flops(useful_channels) +
                         3 * newton_solve_flops(useful_channels);  // three solves a step or more
    compare_with_limit(
        state, iterations / static_cast<double>(state.iterations()) * flops / gemm_double_rate(),
        "gemm_double");
  } else {
    compare_linear(state, name, batch);
  }
}

/// What the front says of a frame: 3 or 19 nuisances.
void look(benchmark::State& state) {
  FitInput input;
  input.validation = &validation();
  const Nuisances nuisances{.level = 0.1, .gradient = 0.1, .electrodes = state.range(0) ? 0.02 : 0};
  const Front front(input.sensor, FrameCheck(input, 0), nuisances);
  Eigen::Index f = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(front.look(frames().row(f).data()));
    f = (f + 1) % most_frames;
  }
}
BENCHMARK(look)->Name("front/look")->Arg(0)->Arg(1);

void fit(benchmark::State& state, const std::string& name) {
  for (auto _ : state) {
    const std::unique_ptr<Solver> solver = make(name);
    solver->fit(FitInput{});
  }
}

/// The factorisation with this many channels, which dominates a Newton step of PDIPM.
void newton_factor(benchmark::State& state) {
  const TotalVariation problem{Sensor{}};
  NewtonSystem system(problem);
  const Eigen::VectorXd weights = Eigen::VectorXd::Ones(problem.edges().count());
  for (auto _ : state) benchmark::DoNotOptimize(system.factor(weights, state.range(0)));
  compare_with_limit(state,
                     newton_factor_flops(static_cast<double>(state.range(0))) / gemm_double_rate(),
                     "gemm_double");
}
BENCHMARK(newton_factor)->Name("newton/factor")->Arg(64)->Arg(112);

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
  // G is read twice.
  const std::int64_t bytes = (right.size() - 1) * state.range(0) * std::int64_t{sizeof(double)};
  compare_with_limit(state, 2 * streaming_time(bytes), "stream");
}
BENCHMARK(newton_solve)->Name("newton/solve")->Arg(64)->Arg(112);

/// Means of reciprocal pairs of a sequence, [frames, pairs] V: a disc moving in a circle, 50 dB.
const Eigen::MatrixXd& sequence() {
  static const Eigen::MatrixXd means = [] {
    constexpr int count = 256;
    const Sensor sensor;
    const EllipseModel model(sensor);
    const double noise = BorderModel(sensor).reference_voltages().norm() * std::pow(10, -2.5) /
                         std::sqrt(2.0 * sensor.channels());
    Eigen::MatrixXd out(count, model.pairs());
    EllipseModel::Workspace workspace;
    Eigen::VectorXd change(model.pairs());
    for (int f = 0; f < count; ++f) {
      EllipticContact disc;
      const double angle = 2 * std::numbers::pi * f / count;
      disc.centre = {0.5 * std::cos(angle), 0.5 * std::sin(angle)};
      disc.log_size = std::log(0.2);
      disc.log_ratio = std::log(0.6);
      model.place(std::span(&disc, 1), workspace);
      model.evaluate(workspace, change);
      RandomStream random(1, key_of("sequence"), static_cast<std::uint64_t>(f), Purpose::noise);
      for (Eigen::Index p = 0; p < out.cols(); ++p) out(f, p) = change[p] + noise * random.normal();
    }
    return out;
  }();
  return means;
}

/// Images the sequence, each frame from scratch or from the contacts of the last.
void contact_fit(benchmark::State& state, bool followed, bool ellipses) {
  const Sensor sensor;
  const double noise = BorderModel(sensor).reference_voltages().norm() * std::pow(10, -2.5) /
                       std::sqrt(static_cast<double>(sensor.channels()));
  ContactFit::Options options;
  options.ellipses = ellipses;
  const ContactFit fit(sensor, ContactPrior{}, whitening_of(sensor, noise, {}), options);
  ContactFit::Workspace workspace;
  ContactFit::Found found;
  Eigen::Index frame = 0;
  double iterations = 0;
  for (auto _ : state) {
    const Eigen::VectorXd means = sequence().row(frame);
    if (followed) {
      fit.follow(means, found.best, workspace, found);
    } else {
      fit.fit(means, workspace, found);
    }
    iterations += found.iterations;
    frame = (frame + 1) % sequence().rows();
  }
  state.counters["iterations"] = iterations / static_cast<double>(state.iterations());
}
BENCHMARK_CAPTURE(contact_fit, discs_from_nothing, false, false);
BENCHMARK_CAPTURE(contact_fit, discs_followed, true, false);
BENCHMARK_CAPTURE(contact_fit, ellipses_from_nothing, false, true);
BENCHMARK_CAPTURE(contact_fit, ellipses_followed, true, true);

void register_all() {
  register_rate("gemm_double", gemm_double_rate);
  for (const char* name : {"one-step-gn", "tsvd"}) register_streaming(matrix_bytes(name));
  for (const auto& [name, spec] : specs()) {
    auto* const run =
        benchmark::RegisterBenchmark(("reconstruct/" + name).c_str(), reconstruct, name);
    for (const int batch : {1, 16, 64, 256, 1024}) run->Arg(batch);
    benchmark::RegisterBenchmark(("fit/" + name).c_str(), fit, name)->Unit(benchmark::kMillisecond);
  }
}

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) {
  ertbench::register_all();
  return ertbench::run_benchmarks(argc, argv);
}
