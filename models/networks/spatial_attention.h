#pragma once

#include <torch/nn/modules/conv.h>
#include <torch/nn/pimpl.h>

#include "models/inference/plan_builder.h"

namespace ertbench {

/// Spatial attention (B2 of the DD-ERT supplement): every place of a feature map is weighted by
///
///     sigmoid(convolution 7x7 of [mean over the channels; maximum over the channels]).
class SpatialAttentionImpl final : public torch::nn::Module {
 public:
  SpatialAttentionImpl();
  /// `features` [frames, channels, height, width] -> the same, weighted.
  torch::Tensor forward(const torch::Tensor& features);
  /// The same in a plan: maps -> maps.
  int add_to(PlanBuilder& plan, int maps) const;

 private:
  torch::nn::Conv2d convolution_;
};
TORCH_MODULE(SpatialAttention);

}  // namespace ertbench
