#pragma once

#include <torch/nn/modules/container/sequential.h>

#include <vector>

#include "forward/sheet/sensor.h"
#include "models/networks/network.h"

namespace ertbench {

/// FCNN: dense layers, each but the last with batch normalisation and ReLU,
///
///     208 -> 2304 -> 576 -> 576 -> 576 (linear).
///
/// The trunk of EIT-NN without its convolutions, so that the step between the two shows what the
/// convolutions are worth.
class Fcnn final : public Network {
 public:
  /// `widths`: of the hidden layers.
  Fcnn(const Sensor& sensor, const std::vector<int>& widths);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(bool bfloat16) const override;

 private:
  torch::nn::Sequential layers_;
  int inputs_;
  int rows_;
  int columns_;
};

/// Appends dense layers with batch normalisation and ReLU; returns the width of the last.
int append_dense_layers(torch::nn::Sequential& layers, int inputs, const std::vector<int>& widths);

}  // namespace ertbench
