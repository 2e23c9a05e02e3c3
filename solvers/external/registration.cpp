#include "solvers/external/registration.h"

#include "solvers/external/command_solver.h"

namespace ertbench {

std::vector<SolverType> external_solvers() {
  SolverInfo info;
  info.summary =
      "a program of any language in a process of its own: a line of JSON in, then frames in and "
      "images out (docs/your_method.md)";
  info.parameters = {
      {"command",
       "the program and its arguments, [\"python3\", \"my_method.py\"]; it runs in the "
       "experiment's folder, and what is in the files among these words is part of the fit",
       ParameterRole::file},
      {"files", "further files whose contents are part of the fit; default none",
       ParameterRole::file},
      {"parameters", "an object that the program gets as it is; default {}"},
      {"ready_limit_s", "until it is ready, > 0; default 3600"},
      {"frame_limit_s", "for each frame, > 0; default 10"},
      {"memory_limit_mb", "of all its processes, 1 ...; default that of the trial"}};
  info.make = make_from_json<CommandSolver>;
  // What a program computes, and with what libraries, is its own business: by rounding.
  info.comparison = ImageComparison::rounding;
  return {{CommandSolver::type, info}};
}

}  // namespace ertbench
