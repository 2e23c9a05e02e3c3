#include "models/training/adam_state.h"

#include <c10/util/string_utils.h>

namespace ertbench {
namespace {

using torch::optim::AdamParamState;

/// The name that the optimiser's own map has for a parameter.
std::string key_in_optimiser(const torch::Tensor& parameter) {
  return c10::guts::to_string(parameter.unsafeGetTensorImpl());
}

}  // namespace

NamedTensors state_of(const torch::optim::Adam& optimiser) {
  NamedTensors out;
  std::size_t number = 0;
  for (const auto& group : optimiser.param_groups()) {
    for (const torch::Tensor& parameter : group.params()) {
      std::int64_t steps = 0;
      torch::Tensor mean = torch::zeros_like(parameter);
      torch::Tensor mean_square = torch::zeros_like(parameter);
      const auto found = optimiser.state().find(key_in_optimiser(parameter));
      if (found != optimiser.state().end()) {
        const auto& state = static_cast<const AdamParamState&>(*found->second);
        steps = state.step();
        mean = state.exp_avg().detach().clone();
        mean_square = state.exp_avg_sq().detach().clone();
      }
      const std::string prefix = std::to_string(number++) + ".";
      out.push_back({prefix + "steps", torch::tensor(steps, torch::kInt64)});
      out.push_back({prefix + "mean", mean});
      out.push_back({prefix + "mean_square", mean_square});
    }
  }
  return out;
}

void set_state(torch::optim::Adam& optimiser, const NamedTensors& state) {
  std::size_t next = 0;
  for (const auto& group : optimiser.param_groups()) {
    for (const torch::Tensor& parameter : group.params()) {
      auto of_parameter = std::make_unique<AdamParamState>();
      of_parameter->step(state.at(next++).values.item<std::int64_t>());
      of_parameter->exp_avg(state.at(next++).values.clone());
      of_parameter->exp_avg_sq(state.at(next++).values.clone());
      optimiser.state()[key_in_optimiser(parameter)] = std::move(of_parameter);
    }
  }
}

}  // namespace ertbench
