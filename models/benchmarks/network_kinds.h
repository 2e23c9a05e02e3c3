#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "models/networks/network.h"
#include "models/solvers/learned_solver.h"
#include "models/training/objective.h"

namespace ertbench {

/// One of the learned solvers as it is timed.
struct NetworkKind {
  std::string name;
  /// The network with random weights, for the default sensor.
  std::shared_ptr<Network> (*network)();
  std::unique_ptr<Objective> (*objective)(bool bfloat16);
  /// The solver as the registry makes it, not fitted. `training` has the settings of its training.
  std::unique_ptr<Solver> (*solver)(nlohmann::json training);
};

/// fcnn, dcnn, eit-nn, dd-ert with its default of two convolutions in a block, and with the one of
/// the experiments, lean-net.
std::span<const NetworkKind> network_kinds();

}  // namespace ertbench
