#include "models/benchmarks/torch_limits.h"

#include <torch/torch.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/benchmarks/machine_limits.h"
#include "models/networks/torch_runtime.h"

namespace ertbench {

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

}  // namespace ertbench
