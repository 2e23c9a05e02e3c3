#pragma once

#include <memory>

#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// A solver whose images are zero: a process of its own reads the frames as the protocol of
/// programs has them (command_solver.h), and answers at once. What it takes is what the pipes and
/// the two changes of process take. Throws std::system_error where no process can be made.
std::unique_ptr<Solver> echo_solver(const Sensor& sensor);

}  // namespace ertbench
