#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"

namespace ertbench {

class SolverRegistry;
struct Experiment;

/// Where a value of a solver's own JSON stands in the experiment file.
struct Moved {
  std::string from;  ///< "/solvers/0/alpha"
  std::string to;    ///< "/solvers/0/sweep/alpha/1"
};

/// An entry whose solver is to be made once, to have its parameters checked.
struct EntryToCheck {
  SolverEntry* entry = nullptr;
  std::vector<Moved> moved;
};

/// Makes the solvers of all entries: built-in ones here, those of plugins in a child process, so
/// that one which takes its process down, or does not come back, costs its own entry alone
/// (SolverEntry::failure). Throws the InputError of the first entry that has one; what is wrong is
/// said of the place in the file.
void check_entries(std::span<const EntryToCheck> entries, const Experiment& experiment,
                   SolverRegistry& registry);

}  // namespace ertbench
