#include "models/networks/spatial_attention.h"

#include <torch/types.h>

#include "models/networks/plan_layers.h"

namespace ertbench {

SpatialAttentionImpl::SpatialAttentionImpl()
    : convolution_(torch::nn::Conv2dOptions(2, 1, 7).padding(3).bias(false)) {
  register_module("convolution", convolution_);
}

torch::Tensor SpatialAttentionImpl::forward(const torch::Tensor& features) {
  const torch::Tensor summary = torch::cat({features.mean(1, true), features.amax({1}, true)}, 1);
  return features * convolution_->forward(summary).sigmoid();
}

int SpatialAttentionImpl::add_to(PlanBuilder& plan, int maps) const {
  const ConvolutionWeights weights = weights_of(*convolution_, nullptr);
  return plan.attention(maps, weights.kernel, weights.weights);
}

}  // namespace ertbench
