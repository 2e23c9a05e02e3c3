#include "models/benchmarks/network_benchmarking.h"

#include <ATen/record_function.h>
#include <torch/torch.h>
#include <torch/types.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

#include "bench/benchmarks/benchmark_program.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/dense_networks.h"
#include "models/networks/lean_net.h"
#include "models/networks/torch_runtime.h"
#include "models/solvers/solvers.h"
#include "models/training/objective.h"
#include "solvers/check/checked_solver.h"

namespace ertbench {
namespace {

/// Where this thread's calls into libtorch are counted; its callbacks are plain functions.
thread_local Arithmetic* counted = nullptr;

double numbers(const torch::Tensor& tensor) { return static_cast<double>(tensor.numel()); }

void count_product(const torch::Tensor& left, const torch::Tensor& right) {
  counted->dense_flops += 2 * numbers(left) * static_cast<double>(right.size(1));
  counted->dense_bytes += right.numel() * right.element_size();
}

/// A convolution: each pixel of the small side (the output's, or a transposed one's input's) meets
/// the pixels of the large side that are within reach of the kernel.
struct Convolution {
  torch::Tensor weight;
  std::vector<std::int64_t> stride;
  std::vector<std::int64_t> padding;

  double flops(std::int64_t frames, const std::array<std::int64_t, 2>& small,
               const std::array<std::int64_t, 2>& large) const {
    const double maps = numbers(weight) / static_cast<double>(weight.size(2) * weight.size(3));
    const double meetings =
        meetings_along(0, small[0], large[0]) * meetings_along(1, small[1], large[1]);
    return 2 * static_cast<double>(frames) * maps * meetings;
  }

  std::array<std::int64_t, 2> small_side(const torch::Tensor& large) const {
    const auto size = [&](std::size_t side, std::int64_t dimension) {
      return (large.size(dimension) + 2 * padding[side] - weight.size(dimension)) / stride[side] +
             1;
    };
    return {size(0, 2), size(1, 3)};
  }

  /// Without output padding, which nothing here has.
  std::array<std::int64_t, 2> large_side(const torch::Tensor& small) const {
    const auto size = [&](std::size_t side, std::int64_t dimension) {
      return (small.size(dimension) - 1) * stride[side] - 2 * padding[side] +
             weight.size(dimension);
    };
    return {size(0, 2), size(1, 3)};
  }

 private:
  double meetings_along(std::size_t side, std::int64_t small, std::int64_t large) const {
    std::int64_t meetings = 0;
    for (std::int64_t pixel = 0; pixel < small; ++pixel) {
      const std::int64_t first = pixel * stride[side] - padding[side];
      const std::int64_t end = first + weight.size(static_cast<std::int64_t>(side) + 2);
      meetings += std::min(end, large) - std::max<std::int64_t>(first, 0);
    }
    return static_cast<double>(meetings);
  }
};

std::array<std::int64_t, 2> sides(const torch::Tensor& image) {
  return {image.size(2), image.size(3)};
}

/// Called before each operation: its inputs are gone after it.
std::unique_ptr<at::ObserverContext> count(const at::RecordFunction& function) {
  const std::string_view name = function.name();
  const auto inputs = function.inputs();
  const auto tensor = [&](std::size_t i) { return inputs[i].toTensor(); };
  if (name == "aten::mm") count_product(tensor(0), tensor(1));
  if (name == "aten::addmm") count_product(tensor(1), tensor(2));
  if (name == "aten::convolution") {
    const torch::Tensor image = tensor(0);
    const Convolution one{tensor(1), inputs[3].toIntVector(), inputs[4].toIntVector()};
    counted->convolution_flops +=
        inputs[6].toBool() ? one.flops(image.size(0), sides(image), one.large_side(image))
                           : one.flops(image.size(0), one.small_side(image), sides(image));
  }
  if (name == "aten::convolution_backward") {
    const torch::Tensor output = tensor(0);
    const torch::Tensor image = tensor(1);
    const Convolution one{tensor(2), inputs[4].toIntVector(), inputs[5].toIntVector()};
    const bool transposed = inputs[7].toBool();
    // The gradients of input and weight, as far as they are wanted, cost a forward pass each.
    const auto wanted = inputs[10].toBoolList();
    counted->convolution_flops +=
        (wanted[0] + wanted[1]) * one.flops(image.size(0), sides(transposed ? image : output),
                                            sides(transposed ? output : image));
  }
  return nullptr;
}

double convolution_time(const Arithmetic& work) {
  return work.convolution_flops > 0 ? work.convolution_flops / convolution_rate() : 0;
}

}  // namespace

Arithmetic arithmetic_of(const std::function<void()>& call) {
  Arithmetic work;
  counted = &work;
  const at::CallbackHandle handle = at::addThreadLocalCallback(
      at::RecordFunctionCallback(count).needsInputs(true).scopes({at::RecordScope::FUNCTION}));
  call();
  at::removeCallback(handle);
  counted = nullptr;
  return work;
}

double least_time(const Arithmetic& work) {
  return work.dense_flops / best_gemm_float_rate() + convolution_time(work);
}

double least_time_of_one_frame(const Arithmetic& work) {
  return streaming_time(work.dense_bytes) + convolution_time(work);
}

const char* limit_of(const Arithmetic& work) {
  if (work.dense_flops == 0) return "convolution";
  return work.convolution_flops > 0 ? "gemm_float + convolution" : "gemm_float";
}

const char* limit_of_one_frame(const Arithmetic& work) {
  if (work.dense_bytes == 0) return "convolution";
  return work.convolution_flops > 0 ? "stream + convolution" : "stream";
}

double torch_gemm_float_rate() {
  static const double rate = [] {
    const torch::NoGradGuard no_gradients;
    double best = 0;
    for (const std::int64_t size : {512, 1024}) {
      const torch::Tensor a = torch::full({size, size}, 0.5F);
      const torch::Tensor b = torch::full({size, size}, 0.25F);
      torch::Tensor product = torch::empty({size, size});
      const double seconds = least_time([&] { torch::mm_out(product, a, b); });
      best = std::max(best, 2 * static_cast<double>(size * size * size) / seconds);
    }
    return best;
  }();
  return rate;
}

double best_gemm_float_rate() { return std::max(torch_gemm_float_rate(), gemm_float_rate()); }

double convolution_rate() {
  static const double rate = [] {
    struct Shape {
      std::int64_t frames, channels, side;
    };
    const torch::NoGradGuard no_gradients;
    double best = 0;
    for (const auto& [frames, channels, side] :
         {Shape{16, 64, 24}, Shape{16, 128, 24}, Shape{4, 256, 24}, Shape{4, 128, 56}}) {
      const torch::Tensor input = torch::full({frames, channels, side, side}, 0.5F).to_mkldnn();
      const torch::Tensor weight = torch::mkldnn_reorder_conv2d_weight(
          torch::full({channels, channels, 3, 3}, 0.25F).to_mkldnn(), {1, 1}, {1, 1}, {1, 1}, 1);
      const double seconds = least_time([&] { torch::conv2d(input, weight, {}, 1, 1); });
      const auto flops = static_cast<double>(2 * 9 * frames * channels * channels * side * side);
      best = std::max(best, flops / seconds);
    }
    return best;
  }();
  return rate;
}

void register_torch_limits() {
  const nlohmann::json runtime = start_torch(1);
  for (const auto& [name, value] : runtime.items()) {
    benchmark::AddCustomContext(name, value.is_string() ? value.get<std::string>() : value.dump());
  }
  register_rate("gemm_float/eigen", gemm_float_rate);
  register_rate("gemm_float/torch", torch_gemm_float_rate);
  register_rate("convolution", convolution_rate);
}

namespace {

using nlohmann::json;

std::unique_ptr<Objective> squared_error(bool) { return std::make_unique<SquaredError>(); }

std::unique_ptr<Objective> adversarial(bool bfloat16) {
  return std::make_unique<AdversarialObjective>(AdversarialSettings{.bfloat16 = bfloat16});
}

template <typename Learned>
std::unique_ptr<Solver> solver(json training) {
  const SolverInfo info = {"", {}, make_from_json<Learned>};
  return CheckedSolver::make(Learned::type, info, JsonObject(training, "benchmark", ""));
}

std::shared_ptr<Network> lean_net() { return std::make_shared<LeanNet>(Sensor{}, LeanShape{}); }

template <int convolutions>
std::shared_ptr<Network> dd_ert() {
  return std::make_shared<DdErtGenerator>(Sensor{}, GeneratorShape{.convolutions = convolutions});
}

template <int convolutions>
std::unique_ptr<Solver> dd_ert_solver(json training) {
  training["convolutions"] = convolutions;
  training["initialisation"] = "random";
  return solver<DdErtSolver>(training);
}

}  // namespace

std::span<const NetworkKind> network_kinds() {
  static const NetworkKind kinds[] = {
      {"fcnn",
       []() -> std::shared_ptr<Network> {
         return std::make_shared<Fcnn>(Sensor{}, std::vector{2304, 576, 576});
       },
       squared_error, solver<FcnnSolver>},
      {"dcnn",
       []() -> std::shared_ptr<Network> {
         return std::make_shared<Dcnn>(Sensor{}, std::array{64, 128, 256});
       },
       squared_error, solver<DcnnSolver>},
      {"eit-nn",
       []() -> std::shared_ptr<Network> {
         return std::make_shared<EitNn>(Sensor{}, std::vector{2304, 576, 576}, std::array{32, 64});
       },
       squared_error,
       [](json training) {
         training["loss"] = "mse";  // without a choice of the blur
         return solver<EitNnSolver>(training);
       }},
      {"dd-ert", dd_ert<2>, adversarial, dd_ert_solver<2>},
      {"dd-ert/convolutions:1", dd_ert<1>, adversarial, dd_ert_solver<1>},
      {"lean-net", lean_net,
       [](bool) -> std::unique_ptr<Objective> { return std::make_unique<RelativeError>(); },
       solver<LeanNetSolver>},
  };
  return kinds;
}

}  // namespace ertbench
