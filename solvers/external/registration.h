#pragma once

#include <vector>

#include "solvers/solver_info.h"

namespace ertbench {

/// The solvers of this room.
std::vector<SolverType> external_solvers();

}  // namespace ertbench
