#pragma once

#include <torch/types.h>

#include <cstdint>
#include <vector>

#include "models/networks/tensor_file.h"

namespace ertbench {

/// Adam (Kingma and Ba 2015) over groups of parameters, each with a learning rate of its own.
///
/// An operation takes all tensors of a group at once: on a GPU, a dozen launches in place of
/// hundreds. Parameters without a gradient stay as they are.
class Adam {
 public:
  using Group = std::vector<torch::Tensor>;

  /// `first_decay`: of the running mean of the gradient.
  explicit Adam(const std::vector<Group>& groups, double first_decay = 0.9);

  void set_rate(std::size_t group, double rate) { groups_.at(group).rate = rate; }
  void zero_grad();
  void step();

  /// By parameter, numbered through the groups: "0.steps", and "0.mean" and "0.mean_square" of the
  /// gradient. A parameter without a step has zeros, which leave its first step unchanged. Deep
  /// copies.
  NamedTensors state() const;
  /// Restores the result of `state`, in its order, of an optimiser of the same parameters.
  void set_state(const NamedTensors& state);

 private:
  struct Parameter {
    torch::Tensor values;
    torch::Tensor mean;  ///< as values, undefined before the first step
    torch::Tensor mean_square;
    std::int64_t steps = 0;
  };
  struct Rated {
    std::vector<Parameter> parameters;
    double rate = 1e-3;
  };

  void step(Rated& group) const;

  std::vector<Rated> groups_;
  double first_decay_;
};

}  // namespace ertbench
