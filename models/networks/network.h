#pragma once

#include <torch/nn/module.h>

#include <vector>

namespace ertbench {

/// A network from frames to images. Its input is standardised (Standardisation); its output is
/// y = (1 - sigma / background) / Standardisation::image, 0 where nothing touches.
class Network : public torch::nn::Module {
 public:
  /// `frames` [frames, channels] -> images [frames, 1, grid, grid].
  virtual torch::Tensor forward(const torch::Tensor& frames) = 0;

  /// Parameters that begin where they should about stay and learn more slowly than the others.
  virtual std::vector<torch::Tensor> slow_parameters() const { return {}; }
};

}  // namespace ertbench
