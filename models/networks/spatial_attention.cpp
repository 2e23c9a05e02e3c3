#include "models/networks/spatial_attention.h"

#include <torch/types.h>

namespace ertbench {

SpatialAttentionImpl::SpatialAttentionImpl()
    : convolution_(torch::nn::Conv2dOptions(2, 1, 7).padding(3).bias(false)) {
  register_module("convolution", convolution_);
}

torch::Tensor SpatialAttentionImpl::forward(const torch::Tensor& features) {
  const torch::Tensor summary = torch::cat({features.mean(1, true), features.amax({1}, true)}, 1);
  return features * convolution_->forward(summary).sigmoid();
}

}  // namespace ertbench
