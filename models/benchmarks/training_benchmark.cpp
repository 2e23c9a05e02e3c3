// What a training step costs: a batch through the whole step of each network (images, losses,
// gradients, Adam; for dd-ert generator and discriminator), data at hand.
//
//   training_benchmark --benchmark_filter=dd-ert
//
// The counter ms_per_sample is wall time; bench/pytorch_comparison.py holds it against PyTorch.

#include <benchmark/benchmark.h>
#include <torch/torch.h>

#include <nlohmann/json.hpp>

#include "models/adversarial_objective.h"
#include "models/dcnn.h"
#include "models/dd_ert_generator.h"
#include "models/eit_nn.h"
#include "models/fcnn.h"
#include "models/frozen_graph.h"
#include "models/reduced_precision.h"
#include "models/torch_runtime.h"

namespace ertbench {
namespace {

constexpr int channels = 208;

struct Kind {
  const char* name;
  std::shared_ptr<Network> (*network)();
  std::unique_ptr<Objective> (*objective)(bool bfloat16);
};

std::unique_ptr<Objective> squared_error(bool) { return std::make_unique<SquaredError>(); }

const Kind kinds[] = {
    {"fcnn",
     []() -> std::shared_ptr<Network> {
       return std::make_shared<Fcnn>(Sensor{}, std::vector{2304, 576, 576});
     },
     squared_error},
    {"dcnn",
     []() -> std::shared_ptr<Network> {
       return std::make_shared<Dcnn>(Sensor{}, std::array{64, 128, 256});
     },
     squared_error},
    {"eit-nn",
     []() -> std::shared_ptr<Network> {
       return std::make_shared<EitNn>(Sensor{}, std::vector{2304, 576, 576}, std::array{32, 64});
     },
     squared_error},
    {"dd-ert",
     []() -> std::shared_ptr<Network> {
       return std::make_shared<DdErtGenerator>(Sensor{}, GeneratorShape{});
     },
     [](bool bfloat16) -> std::unique_ptr<Objective> {
       return std::make_unique<AdversarialObjective>(AdversarialSettings{.bfloat16 = bfloat16});
     }},
};

void training_step(benchmark::State& state, const Kind& kind, int threads, int batch,
                   bool bfloat16) {
  start_torch(threads);
  torch::manual_seed(1);
  const std::shared_ptr<Network> network = kind.network();
  const std::unique_ptr<Objective> objective = kind.objective(bfloat16);
  torch::optim::Adam optimiser(network->parameters());
  objective->set_learning_rate(1e-3);
  network->train();
  const torch::Tensor frames = torch::randn({batch, channels});
  const torch::Tensor truths = (torch::rand({batch, 1, 24, 24}) > 0.9).to(torch::kFloat32) * 0.4;
  std::vector<double> terms(objective->terms().size());
  for (auto _ : state) {
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
  state.counters["ms_per_sample"] =
      benchmark::Counter(1e-3 * static_cast<double>(state.iterations() * batch),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void one_frame(benchmark::State& state, const Kind& kind, bool frozen) {
  start_torch(1);
  torch::manual_seed(1);
  const std::shared_ptr<Network> network = kind.network();
  const FrozenGraph graph(*network, channels);
  const torch::Tensor frame = torch::randn({1, channels});
  const torch::NoGradGuard no_gradients;
  for (auto _ : state) {
    benchmark::DoNotOptimize(frozen ? graph.run(frame) : network->forward(frame));
  }
}

void register_all() {
  for (const Kind& kind : kinds) {
    for (const int threads : {1, 2}) {
      for (const bool bfloat16 : {false, true}) {
        const std::string name = std::string("training_step/") + kind.name +
                                 "/threads:" + std::to_string(threads) +
                                 (bfloat16 ? "/bfloat16" : "/float32");
        benchmark::RegisterBenchmark(name.c_str(),
                                     [=, &kind](benchmark::State& state) {
                                       training_step(state, kind, threads, 32, bfloat16);
                                     })
            ->UseRealTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
    for (const bool frozen : {true, false}) {
      const std::string name =
          std::string("one_frame/") + kind.name + (frozen ? "/frozen" : "/eager");
      benchmark::RegisterBenchmark(
          name.c_str(), [=, &kind](benchmark::State& state) { one_frame(state, kind, frozen); })
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
}

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) {
  ertbench::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
