#pragma once

#include <vector>

#include "solvers/solver_info.h"

namespace ertbench {

/// The solvers of this folder, for the registry.
std::vector<SolverType> iterated_solvers();

}  // namespace ertbench
