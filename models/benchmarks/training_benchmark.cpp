// Time of a training step: a batch through the whole step of each network (images, losses,
// gradients, Adam; for dd-ert generator and discriminator), data at hand.
//
//   build/release/benchmarks/training_benchmark --benchmark_filter=dd-ert
//
// The counter ms_per_sample is wall time; models/benchmarks/pytorch_comparison.py holds it against
// PyTorch. machine_limits.h says what the counters limit_us and of_limit are (float32 alone).
// "Debug" in the header is how Debian's Google Benchmark was built; ertbench itself is a release.

#include <benchmark/benchmark.h>
#include <torch/torch.h>

#include "bench/benchmarks/benchmark_program.h"
#include "models/benchmarks/network_benchmarking.h"
#include "models/networks/torch_runtime.h"

namespace ertbench {
namespace {

constexpr int batch = 32;

/// A network with all that its training needs.
struct Training {
  Training(const NetworkKind& kind, bool reduced)
      : bfloat16(reduced),
        network(kind.network()),
        objective(kind.objective(reduced)),
        optimiser(std::vector<Adam::Group>{network->parameters()}),
        frames(torch::randn({batch, Sensor{}.channels()})),
        truths((torch::rand({batch, 1, 24, 24}) > 0.9).to(torch::kFloat32) * 0.4),
        terms(objective->terms().size()) {
    objective->set_learning_rate(1e-3);
    network->train();
  }

  void step() {
    torch::Tensor images;
    {
      const ReducedPrecision precision(bfloat16);
      images = network->forward(frames).to(torch::kFloat32);
    }
    const torch::Tensor loss = objective->loss(images, truths, terms);
    optimiser.zero_grad();
    loss.backward();
    optimiser.step();
    benchmark::DoNotOptimize(loss.item<float>());
  }

  bool bfloat16;
  std::shared_ptr<Network> network;
  std::unique_ptr<Objective> objective;
  Adam optimiser;
  torch::Tensor frames;
  torch::Tensor truths;
  std::vector<double> terms;
};

void training_step(benchmark::State& state, const NetworkKind& kind, int threads, bool bfloat16) {
  start_torch(threads);
  torch::manual_seed(1);
  Training training(kind, bfloat16);
  for (auto _ : state) training.step();
  state.counters["ms_per_sample"] =
      benchmark::Counter(1e-3 * static_cast<double>(state.iterations() * batch),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  if (bfloat16) return;
  const Arithmetic work = arithmetic_of([&] { training.step(); });
  start_torch(1);  // the limits are those of one thread
  compare_with_limit(state, least_time(work) / threads, limit_of(work));
}

void register_all() {
  register_torch_limits();
  for (const NetworkKind& kind : network_kinds()) {
    for (const int threads : {1, 2}) {
      for (const bool bfloat16 : {false, true}) {
        const std::string name = "training_step/" + kind.name +
                                 "/threads:" + std::to_string(threads) +
                                 (bfloat16 ? "/bfloat16" : "/float32");
        benchmark::RegisterBenchmark(
            name.c_str(),
            [=, &kind](benchmark::State& state) { training_step(state, kind, threads, bfloat16); })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) {
  ertbench::register_all();
  return ertbench::run_benchmarks(argc, argv);
}
