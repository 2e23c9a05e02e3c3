#pragma once

#include <vector>

#include "bench/experiment/solver_entry.h"

namespace ertbench {

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
