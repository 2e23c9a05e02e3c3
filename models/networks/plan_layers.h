#pragma once

#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/container/sequential.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>

#include <vector>

#include "models/inference/inference_plan.h"

/// Converts libtorch's layers to layers of an InferencePlan, with the batch normalisation after
/// each, in evaluation mode, folded into its weights.
namespace ertbench {

/// `normalisation` may be null.
DenseWeights weights_of(const torch::nn::LinearImpl& layer,
                        const torch::nn::BatchNorm1dImpl* normalisation);
ConvolutionWeights weights_of(const torch::nn::Conv2dImpl& layer,
                              const torch::nn::BatchNorm2dImpl* normalisation);
ConvolutionWeights weights_of(const torch::nn::ConvTranspose2dImpl& layer,
                              const torch::nn::BatchNorm2dImpl* normalisation);

/// The numbers of a tensor of integers below 2^31, of its last dimension the fastest.
std::vector<int> integers_of(const torch::Tensor& tensor);

/// Adds a chain of dense layers, convolutions and transposed convolutions, each optionally followed
/// by batch normalisation, ReLU or PRelu, and pooling by 2. The first layer takes `inputs`. With
/// `to_image` the last one is a plain convolution of stride 1 that makes planar maps. Returns the
/// last output; throws std::logic_error for other modules.
int add_layers(PlanBuilder& plan, const torch::nn::Sequential& layers, std::vector<int> inputs,
               bool to_image = false);

}  // namespace ertbench
