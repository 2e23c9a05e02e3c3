#pragma once

#include <filesystem>
#include <string>

namespace ertbench {

/// How this program was built.
struct Build {
  std::string commit;   ///< the last that changed the sources, 12 digits; "unknown" without git
  bool dirty = false;   ///< whether sources had changed since
  std::string sources;  ///< what is looked at, relative to the project: "core forward ..."
  std::string release_probes;  ///< core/release_probes.json, see core/probe.h
};

/// The build of the running program.
const Build& this_build();

/// "0123456789ab", with "-dirty" where sources had changed.
std::string commit_text(const std::string& commit, bool dirty);

/// The folder of the sources that the program was built from: where the program lies in a build
/// folder of it, wherever that was moved to, the folder above; of an installed program
/// share/ertbench of its prefix; else where it was when it was built.
std::filesystem::path project_folder();

/// Where datasets, fitted solvers and probes are kept: $ERTBENCH_CACHE, else `cache` in the
/// project's folder; of an installed program ertbench in $XDG_CACHE_HOME or ~/.cache.
std::filesystem::path cache_folder();

}  // namespace ertbench
