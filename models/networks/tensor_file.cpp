#include "models/networks/tensor_file.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/errors.h"

namespace ertbench {
namespace {

Hdf5File::Number number_of(const torch::Tensor& tensor) {
  if (tensor.dtype() == torch::kFloat32) return Hdf5File::Number::real32;
  if (tensor.dtype() == torch::kInt64) return Hdf5File::Number::int64;
  throw std::logic_error("a tensor to be saved is neither of 32-bit reals nor of 64-bit integers");
}

std::vector<std::uint64_t> shape_of(const torch::Tensor& tensor) {
  if (tensor.dim() == 0) return {1};
  return {tensor.sizes().begin(), tensor.sizes().end()};
}

}  // namespace

void write_tensor(Hdf5File& file, const std::string& dataset, const torch::Tensor& values) {
  const std::vector<std::uint64_t> shape = shape_of(values);
  file.create_dataset(dataset, shape, number_of(values));
  const torch::Tensor wide = values.detach().to(torch::kFloat64).contiguous();
  const auto rows = static_cast<Eigen::Index>(shape[0]);
  file.write_rows(dataset, 0,
                  Eigen::Map<const RowMajorMatrix>(wide.data_ptr<double>(), rows,
                                                   static_cast<Eigen::Index>(wide.numel()) / rows));
}

torch::Tensor read_tensor(const Hdf5File& file, const std::string& dataset,
                          const torch::Tensor& like) {
  const std::vector<std::uint64_t> shape = shape_of(like);
  file.require_number(dataset, number_of(like));
  file.require_shape(dataset, shape);
  const RowMajorMatrix values = file.read_rows(dataset, 0, shape[0], true);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values.data()[i])) continue;
    throw InputError(file.path().string() + ": " + dataset + ": element " + std::to_string(i) +
                     " is not a finite number");
  }
  return torch::from_blob(const_cast<double*>(values.data()), like.sizes(), torch::kFloat64)
      .to(like.dtype(), false, true);
}

void write_tensors(Hdf5File& file, const std::string& group, const NamedTensors& tensors) {
  for (const auto& [name, values] : tensors) write_tensor(file, group + "/" + name, values);
}

NamedTensors read_tensors(const Hdf5File& file, const std::string& group,
                          const NamedTensors& like) {
  for (const std::string& found : file.names(group)) {
    const auto same = [&](const NamedTensor& one) { return one.name == found; };
    if (std::any_of(like.begin(), like.end(), same)) continue;
    throw InputError(file.path().string() + ": " + group + "/" + found +
                     ": has no place in the network");
  }
  NamedTensors out;
  for (const auto& [name, values] : like) {
    out.push_back({name, read_tensor(file, group + "/" + name, values)});
  }
  return out;
}

}  // namespace ertbench
