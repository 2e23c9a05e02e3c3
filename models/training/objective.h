#pragma once

#include <torch/types.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "models/networks/named_tensors.h"

namespace ertbench {

/// What the training of a network minimises, together with whatever is trained against it.
class Objective {
 public:
  virtual ~Objective() = default;

  /// The parts of the loss, as the log's columns call them.
  virtual std::vector<std::string> terms() const { return {}; }

  /// The loss of one batch: `images` as the network made them, `truths`, both [frames, 1, grid,
  /// grid]. Trains the network's opponent first, where there is one. `terms` [terms().size()]
  /// receives the parts.
  virtual torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                             std::vector<double>& terms) = 0;

  /// Before each step's loss: its place in the whole training, from 0.
  virtual void begin_step(std::uint64_t /*step*/, std::uint64_t /*steps*/) {}
  virtual void set_learning_rate(double) {}
  /// After an epoch: what has gone wrong in it, for the status; nothing where all is well.
  virtual std::optional<std::string> collapse() { return std::nullopt; }

  /// All that the next step depends on.
  virtual NamedTensors state() const { return {}; }
  /// Goes on from what `state` gave: the same names, in the same order.
  virtual void set_state(const NamedTensors&) {}
};

/// The relative error of the change of the conductivity, which the tables report,
///
///     mean over the frames of sqrt(|y - y_true|^2 + a^2) / sqrt(|y_true|^2 + b^2),
///
/// a = .01, so that there is a gradient at 0, and b = .55, the norm of a weak small contact (two
/// pixels at y = .4), so that frames that show nothing, or next to it, do not outweigh the others.
class RelativeError final : public Objective {
 public:
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;
};

/// Mean squared error, |y - S y_true|^2 where a blur S is given.
class SquaredError final : public Objective {
 public:
  SquaredError() = default;
  /// `blur` [pixels, pixels].
  explicit SquaredError(const torch::Tensor& blur) : blur_(blur) {}
  torch::Tensor loss(const torch::Tensor& images, const torch::Tensor& truths,
                     std::vector<double>& terms) override;

 private:
  torch::Tensor blur_;
};

}  // namespace ertbench
