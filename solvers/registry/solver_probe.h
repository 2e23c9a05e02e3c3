#pragma once

#include <optional>
#include <string>

#include "core/probe.h"
#include "solvers/registry/registry.h"

namespace ertbench {

/// The probe "solver/TYPE" of one of the program's own types: images, reports and contacts of a few
/// frames by solvers that are made from the settings in SolverInfo::probes and fitted to a few
/// scenes on one thread; with the seeds 1 and 2 where the type has seeds. A new type needs nothing
/// for that.
///
/// From the cache, or computed in a child process, which may load a plugin. Nothing for types of
/// the user's, which are known by the hash of their library, for types without settings to probe,
/// and where the child fails, which is said on stderr.
std::optional<Probe> solver_probe(const std::string& type);

/// solver_probe as an entry of Probes; none where there is none.
Probes solver_probes(const std::string& type);
/// Those of all the program's own types.
Probes all_solver_probes();

/// The probe "front": what a FrameCheck and a Front say and make of sound frames, of electrodes
/// that read zero, half or float, and of another level. Few frames of the probes of solvers are
/// faulty.
Probe front_probe();

/// Computes it in this process, whose registry may load plugins.
Probe computed_solver_probe(SolverRegistry& registry, const std::string& type);

}  // namespace ertbench
