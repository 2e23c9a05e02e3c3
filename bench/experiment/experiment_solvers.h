#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "core/json.h"

namespace ertbench {

class SolverRegistry;
struct Experiment;

/// The place of a value of a solver's own JSON in the experiment file.
struct Moved {
  std::string from;  ///< "/solvers/0/alpha"
  std::string to;    ///< "/solvers/0/sweep/alpha/1"
};

/// An entry whose solver is constructed once to check its parameters.
struct EntryToCheck {
  SolverEntry* entry = nullptr;
  std::vector<Moved> moved;
};

/// Constructs the solvers of all entries, built-in ones here and those of plugins in a child
/// process, so that a solver which ends its process or never returns fails only its own entry
/// (SolverEntry::failure). Throws the first InputError of an entry, with its place in the file.
void check_entries(std::span<const EntryToCheck> entries, const Experiment& experiment,
                   SolverRegistry& registry);

struct SolverInfo;

/// One combination of the values of a sweep.
struct SweepPoint {
  std::string label;  ///< " alpha=0.001 beta=0.1", appended to the entry's own; "" for none
  JsonValue values;   ///< `{"alpha": 0.001, "beta": 0.1}`; null for none
  std::vector<std::size_t> indices;  ///< position of each parameter's value in its list
};

/// Reads `"sweep": {"alpha": [1e-4, 1e-3], "beta": [0.1, 1]}` of a solver's entry: one or two of
/// the solver's parameters (in alphabetical order, as the keys of JSON have none), each with 1 to
/// 50 different values: numbers, strings, true or false, lists of numbers. Returns every
/// combination, the last parameter changing fastest; without a sweep one point without values.
/// `info` may be null for a solver whose parameters are not known here. Throws InputError.
std::vector<SweepPoint> read_sweep(JsonObject& entry, const SolverInfo* info);

enum class SolverCheck;

/// Reads "solvers" of an experiment file, in which an entry with "seeds" or a "sweep" becomes
/// several, the seeds of one label side by side. The experiment's sensor and datasets must be read
/// already. Throws InputError.
std::vector<SolverEntry> read_solvers(JsonObject& root, const Experiment& experiment,
                                      SolverRegistry& registry, SolverCheck check);

/// Copies the facts about the entry's type from its registration. read_solvers does so for all
/// entries if it checks the solvers, else for those whose plugin is already loaded.
void describe(SolverEntry& entry, const SolverInfo& info);

}  // namespace ertbench
