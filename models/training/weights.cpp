#include "models/training/weights.h"

#include <torch/nn/modules/batchnorm.h>

#include <algorithm>

namespace ertbench {

namespace nn = torch::nn;

std::vector<torch::optim::OptimizerParamGroup> parameter_groups(const Network& network) {
  const std::vector<torch::Tensor> slow = network.slow_parameters();
  std::vector<torch::Tensor> others;
  for (const torch::Tensor& parameter : network.parameters()) {
    const auto same = [&](const torch::Tensor& one) { return one.is_same(parameter); };
    if (std::none_of(slow.begin(), slow.end(), same)) others.push_back(parameter);
  }
  return {torch::optim::OptimizerParamGroup(others), torch::optim::OptimizerParamGroup(slow)};
}

void freeze_statistics(Network& network) {
  for (const auto& module : network.modules()) {
    if (module->as<nn::BatchNorm1dImpl>() || module->as<nn::BatchNorm2dImpl>()) {
      module->eval();
    }
  }
}

}  // namespace ertbench
