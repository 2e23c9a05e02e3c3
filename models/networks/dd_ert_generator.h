#pragma once

#include <torch/nn/modules/container/sequential.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>
#include <torch/nn/pimpl.h>

#include <array>

#include "forward/sheet/sensor.h"
#include "models/inference/inference_plan.h"
#include "models/networks/network.h"

namespace ertbench {

/// Spatial attention (B2 of the DD-ERT supplement): every position of a feature map is weighted by
///
///     sigmoid(convolution 7x7 of [mean over the channels; maximum over the channels]).
class SpatialAttentionImpl final : public torch::nn::Module {
 public:
  SpatialAttentionImpl();
  /// `features` [frames, channels, height, width] -> weighted features of the same shape.
  torch::Tensor forward(const torch::Tensor& features);
  /// Adds it to a plan: maps -> maps.
  int add_to(PlanBuilder& plan, int maps) const;

 private:
  torch::nn::Conv2d convolution_;
};
TORCH_MODULE(SpatialAttention);

/// Self-attention over the positions of a feature map x [channels, positions] (Zhang et al. 2019),
/// which B.2.1 names in its text and (B2) does not compute:
///
///     x + g V x softmax((Q x)' K x)',
///
/// Q, K: 1x1 convolutions to an eighth of the channels, V: to all of them, g: learned, from 0.
class SelfAttentionImpl final : public torch::nn::Module {
 public:
  explicit SelfAttentionImpl(int channels);
  /// `features` [frames, channels, height, width] -> attended features of the same shape.
  torch::Tensor forward(const torch::Tensor& features);

 private:
  torch::nn::Conv2d query_, key_, value_;
  torch::Tensor gain_;
};
TORCH_MODULE(SelfAttention);

/// A convolution whose kernel, as a matrix [outputs, inputs * size * size], is divided by its
/// largest singular value (spectral normalisation, Miyato et al. 2018), which bounds the Lipschitz
/// constant of the output.
///
/// The singular value comes from power iteration, one step for every call in training mode. It lags
/// behind the weights by some steps, so that the normalised value may be a few tenths above 1. The
/// singular vector is a buffer, saved and loaded with the weights.
class SpectralConvolutionImpl final : public torch::nn::Module {
 public:
  SpectralConvolutionImpl(int inputs, int outputs, int size, int stride, int padding);

  /// `maps` [frames, inputs, height, width].
  torch::Tensor forward(const torch::Tensor& maps);

  /// The normalised kernel [outputs, inputs, size, size]. Iterates once in training mode.
  torch::Tensor kernel();

 private:
  torch::nn::Conv2d convolution_;
  torch::Tensor left_;  ///< left singular vector [outputs, 1]
  int stride_;
  int padding_;
};
TORCH_MODULE(SpectralConvolution);

/// Settings of DD-ERT's generator; w is `width`.
struct GeneratorShape {
  int width = 24;        ///< feature maps at the full resolution, doubled at each level
  int convolutions = 2;  ///< 3x3 convolutions in a block, each with batch normalisation and ReLU
  bool attention = true;
  bool self_attention = false;  ///< SelfAttention in place of SpatialAttention
};

/// DD-ERT's generator (Zheng et al., supplement, Fig. B1): a dense layer from voltages to a first
/// image (B1), then a U-Net with spatial attention (B2) on its two coarsest maps.
///
///     dense 208 -> 576 = 1 x 24 x 24
///     block w                            24 x 24 ------------------------------ concatenated
///     block 2w, stride 2                 12 x 12 ---------------- concatenated  |
///     block 4w, stride 2, attention       6 x 6  -- concatenated  |             |
///     block 8w, unpadded, attention       4 x 4     |             |             |
///     transposed 3x3 4w -> 6 x 6, block 4w ---------              |             |
///     transposed 2x2 2w, stride 2 -> 12 x 12, block 2w -----------              |
///     transposed 2x2  w, stride 2 -> 24 x 24, block w --------------------------
///     1x1 convolution, sigmoid
class DdErtGenerator final : public Network {
 public:
  /// `told`: further inputs of the dense layer behind the channels.
  DdErtGenerator(const Sensor& sensor, const GeneratorShape& shape, int told = 0);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(PlanBuilder plan) const override;

  /// Parameters of the dense layer.
  std::vector<torch::Tensor> slow_parameters() const override {
    return initial_imaging_->parameters();
  }

  /// The dense layer, for initialisation with a regularised inverse, or freezing.
  torch::nn::Linear& initial_imaging() { return initial_imaging_; }

  /// Throws InputError unless the image can be halved twice with more than 2 pixels left on a side.
  static void check(const Sensor& sensor);

 private:
  int rows_;
  int columns_;
  torch::nn::Linear initial_imaging_;
  torch::nn::Sequential encode_full_, encode_half_, encode_quarter_, bottom_;
  torch::nn::ConvTranspose2d rise_quarter_, rise_half_, rise_full_;
  torch::nn::Sequential decode_quarter_, decode_half_, decode_full_;
  torch::nn::Conv2d image_;
  SpatialAttention attention_quarter_{nullptr}, attention_bottom_{nullptr};  ///< null without it
  SelfAttention self_quarter_{nullptr}, self_bottom_{nullptr};               ///< null without it
};

/// PatchGAN discriminator (Isola et al. 2017, as used by DD-ERT) on patches of 16 x 16 pixels,
///
///     4x4 convolution w0, stride 2, LeakyReLU 0.2       12 x 12
///     4x4 convolution w1, batch norm., LeakyReLU 0.2    11 x 11
///     4x4 convolution 1                                 10 x 10
///
/// each padded by one pixel. With spectral normalisation each convolution is a SpectralConvolution
/// without batch normalisation, whose scales would undo the bound on the kernels.
class PatchDiscriminatorImpl final : public torch::nn::Module {
 public:
  explicit PatchDiscriminatorImpl(const std::array<int, 2>& widths, bool spectral_norm = false);
  /// `images` [frames, 1, grid, grid] -> log-odds that each patch belongs to a true image
  /// [frames, 1, grid/2 - 2, grid/2 - 2].
  torch::Tensor forward(const torch::Tensor& images);

 private:
  torch::nn::Sequential layers_;
};
TORCH_MODULE(PatchDiscriminator);

}  // namespace ertbench
