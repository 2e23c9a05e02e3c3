#pragma once

#include <torch/types.h>

#include <memory>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "core/hdf5_file.h"
#include "models/networks/network.h"

namespace torch::nn {
class Module;
}

namespace ertbench {

/// A tensor and its name in a file.
struct NamedTensor {
  std::string name;
  torch::Tensor values;
};
using NamedTensors = std::vector<NamedTensor>;

/// Parameters ("layers.0.weight") and buffers of a module, in its order; they are the module's own.
NamedTensors weights_of(const torch::nn::Module& module);

/// A copy of a matrix.
torch::Tensor tensor_of(const FloatRows& matrix);

/// Deep copies without gradients.
NamedTensors copies(const NamedTensors& tensors);

/// Copies the values of each tensor into the one at the same position.
void copy_values(const NamedTensors& from, const NamedTensors& to);

/// Appends `tensors` with `prefix` before their names.
void append(NamedTensors& all, const std::string& prefix, const NamedTensors& tensors);

// Tensors as datasets of an HDF5 file: numbers and nothing else, so that a file from elsewhere can
// be read. (What libtorch itself saves holds programs that run when it is read.)

/// Writes one tensor of 32-bit real numbers or 64-bit integers as a dataset of the same type and
/// shape; a tensor without dimensions has the shape [1].
void write_tensor(Hdf5File& file, const std::string& dataset, const torch::Tensor& values);
/// Reads a tensor of the type and shape of `like`. Throws InputError naming the dataset if it is
/// missing, of another type or shape, or has a number that is not finite.
torch::Tensor read_tensor(const Hdf5File& file, const std::string& dataset,
                          const torch::Tensor& like);

/// Writes each tensor as the dataset GROUP/NAME, with `group` such as "/network".
void write_tensors(Hdf5File& file, const std::string& group, const NamedTensors& tensors);
/// Reads tensors with the names, types and shapes of `like`, in its order. Throws InputError like
/// read_tensor, and if the group holds anything else.
NamedTensors read_tensors(const Hdf5File& file, const std::string& group, const NamedTensors& like);

}  // namespace ertbench

namespace torch::jit {
struct GraphExecutor;
}

namespace ertbench {

/// A trained network with its weights as constants: batch normalisations folded into the
/// convolutions and dense layers before them, weights kept in the layout that the processor's
/// convolutions want.
class FrozenGraph {
 public:
  /// Puts `network` into evaluation mode; it must not be trained any further. With `bfloat16` its
  /// weights are rounded permanently, and it computes in bfloat16.
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
