#pragma once

#include <torch/nn/module.h>
#include <torch/nn/pimpl.h>

namespace ertbench {

/// PReLU, a x where x < 0 with a learned a for each channel. Written with ReLU, for which libtorch
/// has fast kernels: its own PReLU is ten times slower in training.
class PReluImpl final : public torch::nn::Module {
 public:
  explicit PReluImpl(int channels)
      : slope_(register_parameter("slope", torch::full({channels, 1, 1}, 0.25))) {}
  torch::Tensor forward(const torch::Tensor& x) { return x.relu() - slope_ * (-x).relu(); }

  const torch::Tensor& slope() const { return slope_; }  ///< [channels, 1, 1]

 private:
  torch::Tensor slope_;
};
TORCH_MODULE(PRelu);

}  // namespace ertbench
