#pragma once

#include <torch/optim/adam.h>

#include "models/networks/named_tensors.h"

namespace ertbench {

/// What Adam remembers of its parameters, numbered through its groups: "0.steps" taken, and
/// "0.mean", "0.mean_square" of the gradient. A parameter that has not been stepped has zeros, with
/// which its first step is the same. Shares nothing with the optimiser.
NamedTensors state_of(const torch::optim::Adam& optimiser);

/// `state`: in the order of state_of for an optimiser of the same parameters.
void set_state(torch::optim::Adam& optimiser, const NamedTensors& state);

}  // namespace ertbench
