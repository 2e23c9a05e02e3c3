#pragma once

#include <vector>

#include "bench/experiment/solver_entry.h"
#include "core/json.h"

namespace ertbench {

class SolverRegistry;
struct Experiment;
struct SolverInfo;
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
