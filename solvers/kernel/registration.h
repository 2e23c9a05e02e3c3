#pragma once

#include <vector>

#include "solvers/solver_info.h"

namespace ertbench {

/// The solvers of this room.
std::vector<SolverType> kernel_solvers();

}  // namespace ertbench
