#pragma once

#include <torch/nn/modules/container/sequential.h>
#include <torch/nn/modules/conv.h>
#include <torch/nn/modules/linear.h>

#include "forward/sheet/sensor.h"
#include "models/networks/network.h"

namespace ertbench {

/// Settings of the lean network; w is `width`.
struct LeanShape {
  int width = 32;         ///< feature maps at half the resolution; twice as many at a quarter
  int blocks = 1;         ///< convolutions at half the resolution, on each side of the bottom
  int bottom_blocks = 4;  ///< convolutions at a quarter of it
  int extra_maps = 4;     ///< further maps of the dense layer beside the image
  bool bounded = true;    ///< sigmoid output, else a correction added to the dense layer's image
};

/// `lean-net`: a dense layer, initialised with the linear estimate of least mean squared error
/// (LMMSE), and a residual network that corrects its image. All convolutions work at half the
/// image's resolution or less, where a map is four times cheaper and a kernel reaches twice as far;
/// each 2 x 2 pixels of the image are four channels there.
///
///     mean of each reciprocal pair of channels, 208 -> 104
///     dense 104 -> (4 + extra) x 12 x 12, four of them the image
///     3x3 convolution w, then `blocks` blocks w               12 x 12 ------ added
///     3x3 convolution 2w, stride 2, `bottom_blocks` blocks 2w  6 x 6         |
///     transposed 2x2 w, stride 2, `blocks` blocks w           12 x 12 -------
///     3x3 convolution 4 -> 1 x 24 x 24, sigmoid (or added to the dense layer's image)
///
/// with batch normalisation and ReLU after each convolution but the last; a block is relu(x +
/// normalised convolution of x).
class LeanNet final : public Network {
 public:
  /// `told`: further inputs of the dense layer, behind the channels of a frame.
  LeanNet(const Sensor& sensor, const LeanShape& shape, int told = 0);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(PlanBuilder plan) const override;

  /// Parameters of the dense layer.
  std::vector<torch::Tensor> slow_parameters() const override { return start_->parameters(); }

  /// Input of the dense layer: means of reciprocal pairs and what is told beside them,
  /// [frames, channels + told] -> [frames, pairs + told].
  torch::Tensor means_of_pairs(const torch::Tensor& frames);
  /// Sets the image of the dense layer to weights [pixels, pairs] times these plus bias [pixels].
  void set_first_image(const torch::Tensor& weights, const torch::Tensor& bias);

  /// Throws InputError unless the image can be halved twice.
  static void check(const Sensor& sensor);

 private:
  torch::Tensor blocks(torch::nn::Sequential& convolutions, torch::Tensor maps);

  int inputs_;  ///< channels, and what is told
  int rows_;    ///< of the maps at half the resolution
  int columns_;
  torch::Tensor pairs_;  ///< [pairs + told, 2] inputs, on the device of the last frames
  torch::nn::Linear start_;
  torch::nn::Sequential encode_, encode_blocks_, fall_, bottom_blocks_;
  torch::nn::ConvTranspose2d rise_;
  torch::nn::Sequential decode_blocks_;
  torch::nn::Conv2d image_;
  bool bounded_;
};

}  // namespace ertbench
