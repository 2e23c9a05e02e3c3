#include "models/networks/patch_discriminator.h"

#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/batchnorm.h>
#include <torch/nn/modules/conv.h>

#include "models/networks/spectral_convolution.h"

namespace ertbench {

namespace nn = torch::nn;

PatchDiscriminatorImpl::PatchDiscriminatorImpl(const std::array<int, 2>& widths,
                                               bool spectral_norm) {
  const auto leaky = [] { return nn::LeakyReLU(nn::LeakyReLUOptions().negative_slope(0.2)); };
  if (spectral_norm) {
    layers_->push_back(SpectralConvolution(1, widths[0], 4, 2, 1));
    layers_->push_back(leaky());
    layers_->push_back(SpectralConvolution(widths[0], widths[1], 4, 1, 1));
    layers_->push_back(leaky());
    layers_->push_back(SpectralConvolution(widths[1], 1, 4, 1, 1));
  } else {
    layers_->push_back(nn::Conv2d(nn::Conv2dOptions(1, widths[0], 4).stride(2).padding(1)));
    layers_->push_back(leaky());
    layers_->push_back(
        nn::Conv2d(nn::Conv2dOptions(widths[0], widths[1], 4).padding(1).bias(false)));
    layers_->push_back(nn::BatchNorm2d(widths[1]));
    layers_->push_back(leaky());
    layers_->push_back(nn::Conv2d(nn::Conv2dOptions(widths[1], 1, 4).padding(1)));
  }
  register_module("layers", layers_);
}

torch::Tensor PatchDiscriminatorImpl::forward(const torch::Tensor& images) {
  return layers_->forward(images);
}

}  // namespace ertbench
