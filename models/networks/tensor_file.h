#pragma once

#include "core/hdf5_file.h"
#include "models/networks/named_tensors.h"

/// Tensors as datasets of an HDF5 file: numbers and nothing else, so that a file from elsewhere can
/// be read. (What libtorch itself saves holds programs that run when it is read.)
namespace ertbench {

/// Writes one tensor of 32-bit real numbers or 64-bit integers as a dataset of the same type and
/// shape; a tensor without dimensions has the shape [1].
void write_tensor(Hdf5File& file, const std::string& dataset, const torch::Tensor& values);
/// A new tensor of the type and shape of `like`. Throws InputError naming the dataset where it is
/// missing, of another type or shape, or has a number that is not finite.
torch::Tensor read_tensor(const Hdf5File& file, const std::string& dataset,
                          const torch::Tensor& like);

/// Each as the dataset GROUP/NAME; `group` is "/network" or the like.
void write_tensors(Hdf5File& file, const std::string& group, const NamedTensors& tensors);
/// New tensors of the names, types and shapes of `like`, in its order. Throws InputError naming the
/// dataset as read_tensor does, and where the group holds anything else.
NamedTensors read_tensors(const Hdf5File& file, const std::string& group, const NamedTensors& like);

}  // namespace ertbench
