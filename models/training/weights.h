#pragma once

#include <torch/optim/optimizer.h>

#include <vector>

#include "models/networks/network.h"

namespace ertbench {

/// All parameters but Network::slow_parameters, and these.
std::vector<torch::optim::OptimizerParamGroup> parameter_groups(const Network& network);

/// From now on batch normalisation uses the statistics gathered so far, not the batch's.
void freeze_statistics(Network& network);

}  // namespace ertbench
