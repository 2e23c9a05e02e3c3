#pragma once

#include <torch/types.h>

#include <string>
#include <vector>

namespace torch::nn {
class Module;
}

namespace ertbench {

/// A tensor and the name under which a file keeps it.
struct NamedTensor {
  std::string name;
  torch::Tensor values;
};
using NamedTensors = std::vector<NamedTensor>;

/// Parameters ("layers.0.weight") and buffers of a module, in its order; they are the module's own.
NamedTensors weights_of(const torch::nn::Module& module);

/// Without gradients, sharing nothing with the originals.
NamedTensors copies(const NamedTensors& tensors);

/// Copies the values of each tensor into the one in the same place.
void copy_values(const NamedTensors& from, const NamedTensors& to);

/// Appends `tensors`, their names behind `prefix`.
void append(NamedTensors& all, const std::string& prefix, const NamedTensors& tensors);

}  // namespace ertbench
