#pragma once

#include <torch/nn/modules/conv.h>

namespace ertbench {

/// A convolution whose kernel, as a matrix [outputs, inputs * size * size], is divided by its
/// largest singular value (spectral normalisation, Miyato et al. 2018): whatever the weights learn,
/// that value of the kernel in use is 1, which bounds how fast the output can change.
///
/// The value is found by power iteration, one step at every call in training mode, so that it
/// follows weights that learn with a lag of some steps, in which the value in use may be a few
/// tenths above 1. The singular vector that it has come to is a buffer, saved and loaded with the
/// weights.
class SpectralConvolutionImpl final : public torch::nn::Module {
 public:
  SpectralConvolutionImpl(int inputs, int outputs, int size, int stride, int padding);

  /// `maps` [frames, inputs, height, width].
  torch::Tensor forward(const torch::Tensor& maps);

  /// The kernel in use [outputs, inputs, size, size]. In training mode it iterates once.
  torch::Tensor kernel();

 private:
  torch::nn::Conv2d convolution_;
  torch::Tensor left_;  ///< left singular vector [outputs, 1]
  int stride_;
  int padding_;
};
TORCH_MODULE(SpectralConvolution);

}  // namespace ertbench
