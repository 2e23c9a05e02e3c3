#include "models/training/objective.h"

#include <torch/nn/functional/loss.h>

namespace ertbench {

torch::Tensor SquaredError::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                 std::vector<double>&) {
  const torch::Tensor target =
      blur_.defined() ? truths.flatten(1).matmul(blur_.t()).view_as(truths) : truths;
  return torch::nn::functional::mse_loss(images, target);
}

}  // namespace ertbench
