#pragma once

#include <optional>

#include "core/layers.h"

namespace ertbench {

/// Interface of solvers whose image is made by a fixed list of layers, which can be exported.
class LayeredSolver {
 public:
  virtual ~LayeredSolver() = default;

  /// Valid after `fit` or `load`; no value for a network that has no such list. Throws InputError
  /// for settings of the inference that layers cannot express.
  virtual std::optional<LayerList> layers() const = 0;
};

}  // namespace ertbench
