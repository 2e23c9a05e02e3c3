#include "models/networks/named_tensors.h"

#include <torch/nn/module.h>
#include <torch/utils.h>

namespace ertbench {

NamedTensors weights_of(const torch::nn::Module& module) {
  NamedTensors weights;
  for (const auto& item : module.named_parameters()) weights.push_back({item.key(), item.value()});
  for (const auto& item : module.named_buffers()) weights.push_back({item.key(), item.value()});
  return weights;
}

NamedTensors copies(const NamedTensors& tensors) {
  NamedTensors out;
  for (const auto& [name, values] : tensors) out.push_back({name, values.detach().clone()});
  return out;
}

void copy_values(const NamedTensors& from, const NamedTensors& to) {
  const torch::NoGradGuard no_gradients;
  for (std::size_t i = 0; i < to.size(); ++i) {
    torch::Tensor target = to[i].values;
    target.copy_(from.at(i).values);
  }
}

void append(NamedTensors& all, const std::string& prefix, const NamedTensors& tensors) {
  for (const auto& [name, values] : tensors) all.push_back({prefix + name, values});
}

}  // namespace ertbench
