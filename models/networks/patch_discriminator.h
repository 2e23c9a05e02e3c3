#pragma once

#include <torch/nn/modules/container/sequential.h>

#include <array>

namespace ertbench {

/// PatchGAN discriminator (Isola et al. 2017, as DD-ERT uses it): judges patches of 16 x 16 pixels
/// of an image,
///
///     4x4 convolution w0, stride 2, LeakyReLU 0.2       12 x 12
///     4x4 convolution w1, batch norm., LeakyReLU 0.2    11 x 11
///     4x4 convolution 1                                 10 x 10
///
/// each padded by one pixel. With spectral normalisation each convolution is a SpectralConvolution,
/// and there is no batch normalisation, whose own scales would undo the bound on the kernels.
class PatchDiscriminatorImpl final : public torch::nn::Module {
 public:
  explicit PatchDiscriminatorImpl(const std::array<int, 2>& widths, bool spectral_norm = false);
  /// `images` [frames, 1, grid, grid] -> log-odds of each patch being of a true image
  /// [frames, 1, grid/2 - 2, grid/2 - 2].
  torch::Tensor forward(const torch::Tensor& images);

 private:
  torch::nn::Sequential layers_;
};
TORCH_MODULE(PatchDiscriminator);

}  // namespace ertbench
