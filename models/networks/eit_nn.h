#pragma once

#include <torch/nn/modules/container/sequential.h>

#include <array>
#include <vector>

#include "forward/sheet/sensor.h"
#include "models/networks/network.h"

namespace ertbench {

/// EIT-NN (Park, Park, Jang, Kim: "Deep neural network based electrical impedance tomographic
/// sensing methodology for large-area robotic tactile sensing", T-RO 2021):
///
///     dense 208 -> 2304 -> 576 -> 576 (batch normalisation, ReLU) -> 1 x 24 x 24
///     -> 3x3 convolution 32 -> 3x3 convolution 64 (batch normalisation, ReLU, no bias)
///     -> 3x3 transposed convolution 1 (linear)
class EitNn final : public Network {
 public:
  /// `dense_widths`: the last must be the number of pixels. `channels`: of the two convolutions.
  EitNn(const Sensor& sensor, const std::vector<int>& dense_widths,
        const std::array<int, 2>& channels);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(bool bfloat16) const override;

 private:
  torch::nn::Sequential dense_;
  torch::nn::Sequential convolutions_;
  int inputs_;
  int rows_;
  int columns_;
};

}  // namespace ertbench
