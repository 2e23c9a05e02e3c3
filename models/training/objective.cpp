#include "models/training/objective.h"

#include <torch/nn/functional/loss.h>

namespace ertbench {
namespace {

constexpr double error_floor = 0.01;
constexpr double truth_floor = 0.55;

}  // namespace

torch::Tensor SquaredError::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                 std::vector<double>&) {
  const torch::Tensor target =
      blur_.defined() ? truths.flatten(1).matmul(blur_.t()).view_as(truths) : truths;
  return torch::nn::functional::mse_loss(images, target);
}

torch::Tensor RelativeError::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                  std::vector<double>&) {
  const auto norm = [](const torch::Tensor& maps, double floor) {
    return (maps.flatten(1).square().sum(1) + floor * floor).sqrt();
  };
  return (norm(images - truths, error_floor) / norm(truths, truth_floor)).mean();
}

}  // namespace ertbench
