#pragma once

#include <torch/optim/optimizer.h>

#include <vector>

#include "models/networks/network.h"

namespace ertbench {

/// Parameters and buffers, in the network's order.
std::vector<torch::Tensor> weights_of(const Network& network);
void set_weights(Network& network, const std::vector<torch::Tensor>& weights);
/// Without gradients, sharing nothing with the originals.
std::vector<torch::Tensor> copies(const std::vector<torch::Tensor>& tensors);

/// All parameters but Network::slow_parameters, and these.
std::vector<torch::optim::OptimizerParamGroup> parameter_groups(const Network& network);

/// From now on batch normalisation uses the statistics gathered so far, not the batch's.
void freeze_statistics(Network& network);

}  // namespace ertbench
