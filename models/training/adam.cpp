#include "models/training/adam.h"

#include <ATen/ATen.h>

#include <cmath>
#include <string>

namespace ertbench {
namespace {

constexpr double second_decay = 0.999;
constexpr double least_deviation = 1e-8;

}  // namespace

Adam::Adam(const std::vector<Group>& groups, double first_decay) : first_decay_(first_decay) {
  for (const Group& group : groups) {
    Rated& rated = groups_.emplace_back();
    for (const torch::Tensor& values : group) rated.parameters.push_back({values, {}, {}});
  }
}

void Adam::zero_grad() {
  for (Rated& group : groups_) {
    for (Parameter& parameter : group.parameters) parameter.values.mutable_grad().reset();
  }
}

void Adam::step() {
  const torch::NoGradGuard no_gradients;
  for (Rated& group : groups_) step(group);
}

void Adam::step(Rated& group) const {
  std::vector<torch::Tensor> values, gradients, means, mean_squares;
  std::int64_t steps = 0;  // those that have a gradient have it in every step
  for (Parameter& parameter : group.parameters) {
    if (!parameter.values.grad().defined()) continue;
    if (!parameter.mean.defined()) {
      parameter.mean = torch::zeros_like(parameter.values);
      parameter.mean_square = torch::zeros_like(parameter.values);
    }
    steps = ++parameter.steps;
    values.push_back(parameter.values);
    gradients.push_back(parameter.values.grad());
    means.push_back(parameter.mean);
    mean_squares.push_back(parameter.mean_square);
  }
  if (values.empty()) return;
  const auto count = static_cast<double>(steps);
  at::_foreach_mul_(means, first_decay_);
  at::_foreach_add_(means, gradients, 1 - first_decay_);
  at::_foreach_mul_(mean_squares, second_decay);
  at::_foreach_addcmul_(mean_squares, gradients, gradients, 1 - second_decay);
  std::vector<torch::Tensor> deviations = at::_foreach_sqrt(mean_squares);
  at::_foreach_div_(deviations, std::sqrt(1 - std::pow(second_decay, count)));
  at::_foreach_add_(deviations, least_deviation);
  at::_foreach_addcdiv_(values, means, deviations,
                        -group.rate / (1 - std::pow(first_decay_, count)));
}

NamedTensors Adam::state() const {
  NamedTensors out;
  std::size_t number = 0;
  for (const Rated& group : groups_) {
    for (const auto& [values, mean, mean_square, steps] : group.parameters) {
      const std::string prefix = std::to_string(number++) + ".";
      const auto copy = [&values = values](const torch::Tensor& tensor) {
        return tensor.defined() ? tensor.clone() : torch::zeros_like(values).detach();
      };
      out.push_back({prefix + "steps", torch::tensor(steps, torch::kInt64)});
      out.push_back({prefix + "mean", copy(mean)});
      out.push_back({prefix + "mean_square", copy(mean_square)});
    }
  }
  return out;
}

void Adam::set_state(const NamedTensors& state) {
  std::size_t next = 0;
  for (Rated& group : groups_) {
    for (Parameter& parameter : group.parameters) {
      const auto copy = [&] {
        return state.at(next++).values.to(parameter.values.device(), false, true);
      };
      parameter.steps = state.at(next++).values.item<std::int64_t>();
      parameter.mean = copy();
      parameter.mean_square = copy();
    }
  }
}

}  // namespace ertbench
