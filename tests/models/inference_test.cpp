// The plans of single frames against libtorch: the same layers, nothing of ours.

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <torch/torch.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "models/inference/inference_plan.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/dense_networks.h"
#include "models/networks/lean_net.h"
#include "models/networks/network.h"
#include "models/networks/plan_layers.h"

namespace ertbench {
namespace {

namespace nn = torch::nn;

/// Rounding of sums of a few thousand products in float32.
constexpr double tolerance = 1e-5;

double difference(const torch::Tensor& a, const torch::Tensor& b) {
  return ((a.flatten() - b.flatten()).norm() / b.norm()).item<double>();
}

/// Weights, slopes and statistics of a network that has learnt something.
void disturb(Network& network, std::int64_t channels) {
  torch::NoGradGuard no_gradients;
  network.train();
  for (int i = 0; i < 3; ++i) network.forward(torch::randn({16, channels}));
  for (torch::Tensor& parameter : network.parameters()) {
    parameter.add_(0.2 * parameter.std(false) * torch::randn_like(parameter) +
                   0.02 * torch::randn_like(parameter));
  }
  network.eval();
}

/// Numbers behind which nothing may be read.
class GuardedNumbers {
 public:
  explicit GuardedNumbers(const torch::Tensor& numbers)
      : page_(static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))),
        bytes_(static_cast<std::size_t>(numbers.numel()) * sizeof(float)),
        pages_((bytes_ + page_ - 1) / page_ * page_),
        place_(static_cast<char*>(::mmap(nullptr, pages_ + page_, PROT_READ | PROT_WRITE,
                                         MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
    ::mprotect(place_ + pages_, page_, PROT_NONE);
    std::memcpy(place_ + pages_ - bytes_, numbers.contiguous().data_ptr<float>(), bytes_);
  }
  GuardedNumbers(const GuardedNumbers&) = delete;
  GuardedNumbers& operator=(const GuardedNumbers&) = delete;
  ~GuardedNumbers() { ::munmap(place_, pages_ + page_); }
  const float* data() const { return reinterpret_cast<const float*>(place_ + pages_ - bytes_); }

 private:
  std::size_t page_;
  std::size_t bytes_;
  std::size_t pages_;
  char* place_;
};

torch::Tensor run(const InferencePlan& plan, const torch::Tensor& frame, std::int64_t outputs) {
  const torch::Tensor image = torch::empty({outputs});
  plan.run(GuardedNumbers(frame).data(), image.data_ptr<float>());
  return image;
}

struct Case {
  std::string name;
  std::function<std::shared_ptr<Network>(const Sensor&)> make;
  Sensor sensor = {};
};

Sensor sensor_of(int electrodes, int grid) {
  Sensor sensor;
  sensor.electrode_count = electrodes;
  sensor.image_grid = grid;
  return sensor;
}

/// Channels without partners: opposite drives.
Sensor without_partners() {
  Sensor sensor;
  sensor.drive.kind = PairPattern::Kind::opposite;
  return sensor;
}

/// Every measurement of every drive is a channel.
Sensor all_measured() {
  Sensor sensor;
  sensor.electrode_model = ElectrodeModel::gap;
  sensor.electrode_width = 0.1;
  sensor.measures_driven = true;
  return sensor;
}

/// The networks as they are by default, and with widths that leave lanes, tiles and groups unused.
std::vector<Case> cases() {
  using Shape = GeneratorShape;
  const auto fcnn = [](std::vector<int> widths) {
    return [=](const Sensor& sensor) { return std::make_shared<Fcnn>(sensor, widths); };
  };
  const auto dcnn = [](std::array<int, 3> widths) {
    return [=](const Sensor& sensor) { return std::make_shared<Dcnn>(sensor, widths); };
  };
  const auto eit_nn = [](std::vector<int> dense, std::array<int, 2> channels) {
    return [=](const Sensor& sensor) { return std::make_shared<EitNn>(sensor, dense, channels); };
  };
  const auto dd_ert = [](const Shape& shape) {
    return [=](const Sensor& sensor) { return std::make_shared<DdErtGenerator>(sensor, shape); };
  };
  const auto lean = [](const LeanShape& shape) {
    return [=](const Sensor& sensor) { return std::make_shared<LeanNet>(sensor, shape); };
  };
  return {
      {"fcnn", fcnn({2304, 576, 576})},
      {"fcnn odd", fcnn({145, 36, 17})},
      {"dcnn", dcnn({64, 128, 256})},
      {"dcnn odd", dcnn({5, 9, 19})},
      {"dcnn all measured", dcnn({8, 16, 16}), all_measured()},
      {"eit-nn", eit_nn({2304, 576, 576}, {32, 64})},
      {"eit-nn odd", eit_nn({64, 576}, {4, 3})},
      {"dd-ert", dd_ert({})},
      {"dd-ert one convolution", dd_ert({.convolutions = 1})},
      {"dd-ert width 1", dd_ert({.width = 1})},
      {"dd-ert width 5", dd_ert({.width = 5, .attention = false})},
      {"dd-ert grid 20", dd_ert({.width = 12}), sensor_of(16, 20)},
      {"lean-net", lean({})},
      {"lean-net linear", lean({.width = 24, .bounded = false})},
      {"lean-net width 3", lean({.width = 3, .blocks = 0, .bottom_blocks = 0, .extra_maps = 0})},
      {"lean-net deep", lean({.width = 20, .blocks = 2, .extra_maps = 7})},
      {"lean-net without partners", lean({.width = 8}), without_partners()},
      {"lean-net grid 36", lean({.width = 16}), sensor_of(24, 36)}};
}

TEST(InferencePlans, AreTheForwardOfEveryNetwork) {
  torch::manual_seed(1);
  const torch::NoGradGuard no_gradients;
  for (const Case& one : cases()) {
    SCOPED_TRACE(one.name);
    const std::shared_ptr<Network> network = one.make(one.sensor);
    disturb(*network, one.sensor.channels());
    const auto plan = network->plan(PlanBuilder());
    ASSERT_TRUE(plan);
    for (int frame = 0; frame < 3; ++frame) {
      const torch::Tensor input = torch::randn({1, one.sensor.channels()});
      EXPECT_LE(difference(run(*plan, input, one.sensor.pixels()), network->forward(input)),
                tolerance);
    }
  }
}

TEST(InferencePlans, InBfloat16AreThoseOfRoundedDenseWeights) {
  torch::manual_seed(2);
  const torch::NoGradGuard no_gradients;
  const auto shared = std::make_shared<Fcnn>(Sensor{}, std::vector{100, 50});
  Fcnn& network = *shared;
  network.eval();
  // Normalisations that do nothing, so that rounding before and behind them is the same.
  for (const auto& module : network.modules()) {
    auto* const normalisation = module->as<nn::BatchNorm1d>();
    if (normalisation) normalisation->running_var.fill_(1 - normalisation->options.eps());
  }
  const auto plan = network.plan(PlanBuilder(true));
  const torch::Tensor frame = torch::randn({1, 208});
  const torch::Tensor exact = network.forward(frame).clone();
  for (torch::Tensor& parameter : network.parameters()) {
    if (parameter.dim() == 2) parameter.copy_(parameter.to(torch::kBFloat16));
  }
  const torch::Tensor image = run(*plan, frame, 576);
  EXPECT_LE(difference(image, network.forward(frame)), tolerance);
  EXPECT_GT(difference(image, exact), 1e-4);
}

TEST(InferencePlans, MayBeSharedByThreads) {
  torch::manual_seed(3);
  const DdErtGenerator network(Sensor{}, {.width = 6});
  const auto plan = network.plan(PlanBuilder());
  const torch::Tensor frames = torch::randn({40, 208});
  const auto images_of = [&] {
    std::vector<torch::Tensor> images;
    for (std::int64_t f = 0; f < frames.size(0); ++f) {
      images.push_back(run(*plan, frames[f], 576));
    }
    return torch::stack(images);
  };
  const torch::Tensor alone = images_of();
  std::vector<torch::Tensor> together(3);
  std::vector<std::thread> threads;
  for (torch::Tensor& images : together) threads.emplace_back([&] { images = images_of(); });
  for (std::thread& thread : threads) thread.join();
  for (const torch::Tensor& images : together) EXPECT_TRUE(images.equal(alone));
}

/// A network of layers in a row, on planar maps of a vector.
void expect_like_libtorch(nn::Sequential layers, int channels, int height, int width) {
  const torch::NoGradGuard no_gradients;
  layers->eval();
  PlanBuilder builder;
  const int size = channels * height * width;
  const int maps = builder.maps(builder.input(size), channels, height, width);
  const auto plan = builder.finish(add_layers(builder, layers, {maps}, true));
  const torch::Tensor input = torch::randn({1, channels, height, width});
  const torch::Tensor expected = layers->forward(input);
  EXPECT_LE(difference(run(*plan, input, expected.numel()), expected), tolerance);
}

nn::Conv2d convolution(int inputs, int outputs, int kernel, int stride = 1, int padding = 0) {
  return nn::Conv2d(nn::Conv2dOptions(inputs, outputs, kernel).stride(stride).padding(padding));
}

TEST(PlanLayers, ConvolveMapsOfAnySize) {
  torch::manual_seed(4);
  for (int height = 3; height <= 14; ++height) {
    for (const int width : {3, 4, 5, 7, 9, 13, 20, 31}) {
      SCOPED_TRACE(std::to_string(height) + " x " + std::to_string(width));
      expect_like_libtorch(
          nn::Sequential(convolution(2, 1 + height * 3, 3, 1, 1), nn::ReLU(),
                         convolution(1 + height * 3, 4 + width, 3, 2, 1), PRelu(4 + width),
                         convolution(4 + width, 1 + height % 4, 1)),
          2, height, width);
    }
  }
}

TEST(PlanLayers, ConvolveWithAnyKernel) {
  torch::manual_seed(5);
  for (const int kernel : {1, 2, 3, 4, 5, 7}) {
    for (const int stride : {1, 2, 3}) {
      for (const int padding : {0, 1, 3}) {
        SCOPED_TRACE(std::to_string(kernel) + " " + std::to_string(stride) + " " +
                     std::to_string(padding));
        expect_like_libtorch(nn::Sequential(convolution(3, 17, kernel, stride, padding),
                                            nn::BatchNorm2d(17), nn::ReLU(), convolution(17, 3, 1)),
                             3, 11, 8);
      }
    }
  }
}

TEST(PlanLayers, EnlargeMaps) {
  torch::manual_seed(6);
  const auto larger = [](int kernel, int stride, int padding = 0) {
    return nn::ConvTranspose2d(
        nn::ConvTranspose2dOptions(20, 11, kernel).stride(stride).padding(padding));
  };
  for (const nn::ConvTranspose2d& layer :
       {larger(2, 2), larger(3, 3), larger(3, 1), larger(3, 2), larger(4, 1, 1), larger(3, 1, 1)}) {
    expect_like_libtorch(nn::Sequential(convolution(2, 20, 1), layer, convolution(11, 2, 3, 1, 1)),
                         2, 5, 7);
  }
}

TEST(PlanLayers, PoolMaps) {
  torch::manual_seed(7);
  expect_like_libtorch(
      nn::Sequential(convolution(1, 20, 3, 1, 1), nn::MaxPool2d(2), convolution(20, 1, 1)), 1, 9,
      12);
}

TEST(PlanBuilder, RefusesWhatDoesNotFitTogether) {
  PlanBuilder builder;
  const int frame = builder.input(10);
  EXPECT_THROW(builder.maps(frame, 2, 2, 2), std::logic_error);
  EXPECT_THROW(builder.dense(frame, {3, 1, {1, 2, 3}, {0}}, {}), std::logic_error);
  EXPECT_THROW(builder.input(3), std::logic_error);
  ConvolutionWeights two_inputs;
  two_inputs.inputs = 2;
  EXPECT_THROW(builder.convolution({frame}, two_inputs, {}), std::logic_error);
}

}  // namespace
}  // namespace ertbench
