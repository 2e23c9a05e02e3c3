#include "models/networks/spectral_convolution.h"

#include <torch/nn/functional/conv.h>

namespace ertbench {
namespace {

/// Before the first training step. The value that the iteration is after is found long before its
/// vector is, and the steps of the training go on with both.
constexpr int first_iterations = 15;
constexpr double least_norm = 1e-12;  ///< of a kernel of zeros, which stays what it is

torch::Tensor normalised(const torch::Tensor& vector) {
  return vector / vector.norm().clamp_min(least_norm);
}

// Products by element and sum: as matrix products they would be rounded to bfloat16 in a training
// of that precision.

torch::Tensor right_of(const torch::Tensor& matrix, const torch::Tensor& left) {
  return normalised((matrix * left).sum(0, true));
}

torch::Tensor left_of(const torch::Tensor& matrix, const torch::Tensor& right) {
  return normalised((matrix * right).sum(1, true));
}

}  // namespace

SpectralConvolutionImpl::SpectralConvolutionImpl(int inputs, int outputs, int size, int stride,
                                                 int padding)
    : convolution_(torch::nn::Conv2dOptions(inputs, outputs, size)),
      left_(normalised(torch::ones({outputs, 1}))),
      stride_(stride),
      padding_(padding) {
  register_module("convolution", convolution_);
  register_buffer("left", left_);
  for (int i = 0; i < first_iterations; ++i) kernel();
}

torch::Tensor SpectralConvolutionImpl::kernel() {
  const torch::Tensor matrix = convolution_->weight.flatten(1);
  torch::Tensor left;
  torch::Tensor right;
  {
    const torch::NoGradGuard no_gradients;
    right = right_of(matrix, left_);
    left = left_of(matrix, right);
    if (is_training()) left_.copy_(left);
  }
  // The vectors are held fixed, so that the gradient is that of the singular value itself.
  const torch::Tensor largest = (matrix * left * right).sum();
  return convolution_->weight / largest.clamp_min(least_norm);
}

torch::Tensor SpectralConvolutionImpl::forward(const torch::Tensor& maps) {
  return torch::nn::functional::conv2d(maps, kernel(),
                                       torch::nn::functional::Conv2dFuncOptions()
                                           .bias(convolution_->bias)
                                           .stride(stride_)
                                           .padding(padding_));
}

}  // namespace ertbench
