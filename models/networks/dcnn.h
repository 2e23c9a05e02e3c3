#pragma once

#include <torch/nn/modules/container/sequential.h>

#include <array>

#include "forward/sheet/sensor.h"
#include "models/networks/network.h"

namespace ertbench {

/// DCNN: the frame laid out as a map, drive down, measurement across, zero where nothing is
/// measured, through a convolutional encoder and decoder:
///
///     1 x 16 x 16 -> 3x3 convolution w0 -> pool -> 3x3 w1 -> pool -> 3x3 w2 (4 x 4)
///     -> transposed convolution 3x3, stride 3, w1 -> transposed 2x2, stride 2, w0
///     -> 3x3 convolution -> 1 x 24 x 24 (linear)
///
/// with batch normalisation and PReLU after each but the last; the usual convolutional baseline of
/// electrical impedance tomography.
class Dcnn final : public Network {
 public:
  /// `widths`: w0, w1, w2.
  Dcnn(const Sensor& sensor, const std::array<int, 3>& widths);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(bool bfloat16) const override;

  /// Throws InputError unless the map can be brought to the image's size: the number of electrodes
  /// a multiple of four, the image's grid 3/2 of it.
  static void check(const Sensor& sensor);

 private:
  torch::nn::Sequential layers_;
  torch::Tensor source_;  ///< [map], which channel stands there; one past the last: none
  int channels_;
  int drives_;
  int measurements_;
};

}  // namespace ertbench
