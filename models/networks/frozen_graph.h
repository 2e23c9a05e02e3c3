#pragma once

#include <torch/types.h>

#include <memory>

#include "models/networks/network.h"

namespace torch::jit {
struct GraphExecutor;
}

namespace ertbench {

/// A trained network with its weights as constants: batch normalisations folded into the
/// convolutions and dense layers before them, weights kept in the layout that the processor's
/// convolutions want.
class FrozenGraph {
 public:
  /// `network` is put into evaluation mode and must not be trained any further. With `bfloat16` its
  /// weights are rounded to that, for good, and all it computes in between.
  FrozenGraph(Network& network, int channels, bool bfloat16 = false);
  ~FrozenGraph();
  FrozenGraph(FrozenGraph&&) noexcept;
  FrozenGraph& operator=(FrozenGraph&&) noexcept;

  /// As Network::forward. Thread-safe.
  torch::Tensor run(const torch::Tensor& frames) const;

 private:
  std::unique_ptr<torch::jit::GraphExecutor> many_frames_;
  std::unique_ptr<torch::jit::GraphExecutor> one_frame_;  ///< with matrix-vector products
  bool bfloat16_;
};

}  // namespace ertbench
