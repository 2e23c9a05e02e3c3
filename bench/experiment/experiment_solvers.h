#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "core/json.h"

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

class JsonObject;
struct SolverInfo;

/// One combination of the values of a sweep.
struct SweepPoint {
  std::string label;  ///< " alpha=0.001 beta=0.1", to stand behind the entry's own; "" for none
  JsonValue values;   ///< `{"alpha": 0.001, "beta": 0.1}`; null for none
  std::vector<std::size_t> indices;  ///< of the values in their lists, parameter by parameter
};

/// Reads `"sweep": {"alpha": [1e-4, 1e-3], "beta": [0.1, 1]}` of a solver's entry: one or two of
/// the solver's parameters (in alphabetical order, as the keys of JSON have none), each with 1 to
/// 50 different values: numbers, strings, true or false, lists of numbers. Returns every
/// combination, the last parameter changing fastest; without a sweep one point without values.
/// `info` may be null for a solver whose parameters are not known here. Throws InputError.
std::vector<SweepPoint> read_sweep(JsonObject& entry, const SolverInfo* info);

class JsonObject;
class SolverRegistry;
struct Experiment;
struct SolverInfo;
enum class SolverCheck;

/// Reads "solvers" of an experiment file, in which an entry with "seeds" or a "sweep" becomes
/// several, the seeds of one label side by side. The experiment's sensor and datasets must be read
/// already. Throws InputError.
std::vector<SolverEntry> read_solvers(JsonObject& root, const Experiment& experiment,
                                      SolverRegistry& registry, SolverCheck check);

/// Fills in what the registration of the entry's type says. read_solvers does so where it needs no
/// plugin to be loaded for that, and, as it checks the solvers, of all.
void describe(SolverEntry& entry, const SolverInfo& info);

}  // namespace ertbench
