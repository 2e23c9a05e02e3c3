#pragma once

#include <torch/nn/module.h>
#include <torch/nn/pimpl.h>

#include <memory>
#include <vector>

#include "models/inference/inference_plan.h"

namespace ertbench {

/// A network from frames to images. Its input is standardised (Standardisation); its output is
/// y = (1 - sigma / background) / Standardisation::image, 0 where nothing touches.
class Network : public torch::nn::Module {
 public:
  /// `frames` [frames, channels] -> images [frames, 1, grid, grid].
  virtual torch::Tensor forward(const torch::Tensor& frames) = 0;

  /// Parameters with a good initialisation, which learn more slowly than the others.
  virtual std::vector<torch::Tensor> slow_parameters() const { return {}; }

  /// The present network as a plan for the inference of single frames, made by `plan`, equal to
  /// `forward` in evaluation mode up to rounding. Null if a network has none: libtorch
  /// images its frames then.
  virtual std::unique_ptr<InferencePlan> plan(PlanBuilder /*plan*/) const { return nullptr; }
};

/// PReLU with a learned slope a for x < 0 in each channel. Built from ReLU, for which libtorch has
/// fast kernels; its own PReLU is ten times slower in training.
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
