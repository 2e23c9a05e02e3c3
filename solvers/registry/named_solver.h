#pragma once

#include <exception>
#include <filesystem>
#include <memory>
#include <string>

#include "core/json.h"
#include "solvers/solver.h"

namespace ertbench {

class SolverRegistry;

/// An entry of a "solvers" list and its file, for messages.
struct NamedSolver {
  JsonValue entry;
  std::string source;
};

/// Reads the value of `--solver`: a JSON file with one entry, or else the name of a stored solver
/// (solvers/check/stored_solver.h). Throws InputError, which names the nearest stored solver, if
/// there is neither.
NamedSolver read_named_solver(const std::string& file_or_name);

/// Makes the solver and fits it, or loads its checkpoint, or what an earlier call kept of a long
/// fit to the sensor alone (core/kept.h). Throws InputError naming its file.
std::unique_ptr<Solver> fitted_solver(const NamedSolver& named, const FitInput& input,
                                      SolverRegistry& registry);

/// Throws InputError that names `plugin` if the solver is one that this program does not have, so
/// that `error` is no defect of the program. `plugin` may be empty.
void blame_plugin(const std::string& file_or_name, const std::filesystem::path& plugin,
                  const std::exception& error);

}  // namespace ertbench
