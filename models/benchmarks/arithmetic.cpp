#include "models/benchmarks/arithmetic.h"

#include <ATen/record_function.h>
#include <torch/types.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "bench/benchmarks/machine_limits.h"
#include "models/benchmarks/torch_limits.h"

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

}  // namespace ertbench
