#pragma once

#include <torch/nn/modules/container/sequential.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>

#include "forward/sheet/sensor.h"
#include "models/networks/network.h"
#include "models/networks/spatial_attention.h"

namespace ertbench {

/// Settings of DD-ERT's generator; w is `width`.
struct GeneratorShape {
  int width = 24;        ///< feature maps at the full resolution; twice as many a level down
  int convolutions = 2;  ///< 3x3 convolutions in a block, each with batch normalisation and ReLU
  bool attention = true;
};

/// DD-ERT's generator (Zheng et al., supplement, Fig. B1): a dense layer that makes a first image
/// of the voltages (B1), then a U-Net with spatial attention (B2) on its two coarsest maps.
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
  DdErtGenerator(const Sensor& sensor, const GeneratorShape& shape);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(bool bfloat16) const override;

  /// The dense layer's.
  std::vector<torch::Tensor> slow_parameters() const override {
    return initial_imaging_->parameters();
  }

  /// The dense layer: to be initialised with a regularised inverse, or frozen.
  torch::nn::Linear& initial_imaging() { return initial_imaging_; }

  /// Throws InputError unless the image can be halved twice and leave more than 2 pixels a side.
  static void check(const Sensor& sensor);

 private:
  torch::Tensor attend(SpatialAttention& attention, const torch::Tensor& features);

  int rows_;
  int columns_;
  torch::nn::Linear initial_imaging_;
  torch::nn::Sequential encode_full_;
  torch::nn::Sequential encode_half_;
  torch::nn::Sequential encode_quarter_;
  torch::nn::Sequential bottom_;
  torch::nn::ConvTranspose2d rise_quarter_;
  torch::nn::ConvTranspose2d rise_half_;
  torch::nn::ConvTranspose2d rise_full_;
  torch::nn::Sequential decode_quarter_;
  torch::nn::Sequential decode_half_;
  torch::nn::Sequential decode_full_;
  torch::nn::Conv2d image_;
  SpatialAttention attention_quarter_{nullptr};  ///< null without attention
  SpatialAttention attention_bottom_{nullptr};
};

}  // namespace ertbench
