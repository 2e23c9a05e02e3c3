#pragma once

#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/container/sequential.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>

#include <vector>

#include "models/inference/inference_plan.h"

/// libtorch's layers as layers of an InferencePlan, each with the batch normalisation behind it, as
/// it is in evaluation mode, folded into its weights.
namespace ertbench {

/// `normalisation` may be null.
DenseWeights weights_of(const torch::nn::LinearImpl& layer,
                        const torch::nn::BatchNorm1dImpl* normalisation);
ConvolutionWeights weights_of(const torch::nn::Conv2dImpl& layer,
                              const torch::nn::BatchNorm2dImpl* normalisation);
ConvolutionWeights weights_of(const torch::nn::ConvTranspose2dImpl& layer,
                              const torch::nn::BatchNorm2dImpl* normalisation);

/// Adds dense layers, convolutions and transposed convolutions with what may follow each of them:
/// batch normalisation, then ReLU or PRelu, then pooling by 2. The first takes `inputs`, the others
/// what comes before them. With `to_image` the last one is a convolution of stride 1 without more
/// and makes planar maps. Returns the last one's output; throws std::logic_error at other modules.
int add_layers(PlanBuilder& plan, const torch::nn::Sequential& layers, std::vector<int> inputs,
               bool to_image = false);

}  // namespace ertbench
