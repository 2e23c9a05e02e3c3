// Time of an image of a learned solver on one thread, with weights of almost no training, on which
// the time does not depend.
//
//   build/release/benchmarks/inference_benchmark
//   build/release/benchmarks/inference_benchmark --benchmark_filter='dd-ert|limit'
//
// `reconstruct/<solver>/<batch>` is the whole way from voltages to images, standardisation
// included; `plan/<solver>` one frame through the network's plan alone, which is what solvers use
// for single frames; `network/<solver>/<batch>` libtorch's frozen graph alone;
// `network_as_trained/<solver>` one frame through the network before it is frozen. Items are
// frames; batch 1 is the latency. machine_limits.h says what the counters limit_us and of_limit
// are. "Debug" in the header is how Debian's Google Benchmark was built; ertbench itself is a
// release.

#include <benchmark/benchmark.h>
#include <torch/torch.h>

#include <map>

#include "bench/benchmarks/benchmark_program.h"
#include "core/files.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/data/scene_model.h"
#include "models/benchmarks/network_benchmarking.h"
#include "models/networks/tensor_file.h"
#include "models/networks/torch_runtime.h"

namespace ertbench {
namespace {

constexpr int batches[] = {1, 16, 64, 256, 1024};
constexpr int most_frames = 1024;

DatasetSpec discs(const std::string& name, std::uint64_t count) {
  DatasetSpec spec;
  spec.name = name;
  spec.count = count;
  spec.noise = {50, SnrBasis::absolute};
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.shapes = {DrawnShape::disc};
  scenes.radius = {0.2, 0.2};
  scenes.conductivity_ratio = {0.6, 0.6};
  spec.scenes = scenes;
  return spec;
}

const Frames& frames() {
  static const Frames changes = [] {
    const DatasetSpec spec = discs("test", most_frames);
    const SceneModel model(spec.sensor, spec.model);
    Frames voltages = generate_block(spec, model, 0, spec.count).voltages;
    voltages.rowwise() -= model.reference_voltages().transpose();
    return voltages;
  }();
  return changes;
}

/// Fitted with a single step, once a process.
const Solver& fitted(const NetworkKind& kind) {
  static std::map<std::string, std::unique_ptr<Solver>> known;
  std::unique_ptr<Solver>& solver = known[kind.name];
  if (!solver) {
    const TemporaryFolder folder("timing");
    generate_dataset(discs("train", 32), folder / "train.h5");
    generate_dataset(discs("validation", 16), folder / "validation.h5");
    const DatasetFile training(folder / "train.h5");
    const DatasetFile validation(folder / "validation.h5");
    FitInput input;
    input.training = &training;
    input.validation = &validation;
    input.work_folder = folder.path();
    solver = kind.solver({{"epochs", 1}, {"batch", 32}});
    solver->fit(input);
  }
  return *solver;
}

Arithmetic arithmetic_of_frames(const NetworkKind& kind, std::int64_t count) {
  const std::shared_ptr<Network> network = kind.network();
  network->eval();
  const torch::Tensor input = torch::zeros({count, Sensor{}.channels()});
  const torch::NoGradGuard no_gradients;
  return arithmetic_of([&] { network->forward(input); });
}

void compare(benchmark::State& state, const NetworkKind& kind, std::int64_t batch) {
  state.SetItemsProcessed(state.iterations() * batch);
  const Arithmetic work = arithmetic_of_frames(kind, batch);
  if (batch == 1) {
    compare_with_limit(state, least_time_of_one_frame(work), limit_of_one_frame(work));
  } else {
    compare_with_limit(state, least_time(work), limit_of(work));
  }
}

void reconstruct(benchmark::State& state, const NetworkKind& kind) {
  const Solver& solver = fitted(kind);
  start_torch(1);
  const Eigen::Index batch = state.range(0);
  Images images(batch, Sensor{}.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(batch));
  Eigen::Index first = 0;
  for (auto _ : state) {
    solver.reconstruct(frames().middleRows(first, batch), images, reports);
    benchmark::ClobberMemory();
    first = (first + batch) % most_frames;
  }
  compare(state, kind, batch);
}

void network(benchmark::State& state, const NetworkKind& kind) {
  start_torch(1);
  torch::manual_seed(1);
  const std::shared_ptr<Network> trained = kind.network();
  const FrozenGraph graph(*trained, Sensor{}.channels());
  const torch::Tensor input = torch::randn({state.range(0), Sensor{}.channels()});
  try {
    graph.run(input);
  } catch (const std::exception&) {
    state.SkipWithError("libtorch's graph of this network fails");
    return;
  }
  for (auto _ : state) benchmark::DoNotOptimize(graph.run(input));
  compare(state, kind, state.range(0));
}

void plan(benchmark::State& state, const NetworkKind& kind) {
  start_torch(1);
  torch::manual_seed(1);
  const std::unique_ptr<InferencePlan> one_frame = kind.network()->plan(PlanBuilder());
  const Eigen::VectorXf input = Eigen::VectorXf::Random(Sensor{}.channels());
  Eigen::VectorXf image(Sensor{}.pixels());
  for (auto _ : state) {
    one_frame->run(input.data(), image.data());
    benchmark::ClobberMemory();
  }
  compare(state, kind, 1);
}

void network_as_trained(benchmark::State& state, const NetworkKind& kind) {
  start_torch(1);
  torch::manual_seed(1);
  const std::shared_ptr<Network> trained = kind.network();
  trained->eval();
  const torch::Tensor input = torch::randn({1, Sensor{}.channels()});
  const torch::NoGradGuard no_gradients;
  for (auto _ : state) benchmark::DoNotOptimize(trained->forward(input));
  compare(state, kind, 1);
}

void register_all() {
  register_torch_limits();
  register_streaming(arithmetic_of_frames(network_kinds().front(), 1).dense_bytes);
  const auto add = [](const std::string& name, auto function, const NetworkKind& kind) {
    return benchmark::RegisterBenchmark(
               name.c_str(), [=, &kind](benchmark::State& state) { function(state, kind); })
        ->Unit(benchmark::kMillisecond);
  };
  for (const NetworkKind& kind : network_kinds()) {
    auto* const whole = add("reconstruct/" + kind.name, reconstruct, kind);
    auto* const frozen = add("network/" + kind.name, network, kind);
    for (const int batch : batches) {
      whole->Arg(batch);
      frozen->Arg(batch);
    }
    add("plan/" + kind.name, plan, kind);
    add("network_as_trained/" + kind.name, network_as_trained, kind);
  }
}

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) {
  ertbench::register_all();
  return ertbench::run_benchmarks(argc, argv);
}
