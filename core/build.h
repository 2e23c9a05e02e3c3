#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace ertbench {

/// Of what this program was built. The hashes are over the contents of source files, the compiler
/// and its flags: two builds with the same hash give the same numbers.
struct Build {
  std::string commit;     ///< the last that changed the sources, 12 digits; "unknown" without git
  bool dirty = false;     ///< whether sources had changed since
  std::string sources;    ///< what is looked at, relative to the project: "core forward ..."
  std::string data_code;  ///< of what datasets depend on: core/, forward/; see cmake/build.cmake
  /// Of what the fitted solvers of a room depend on, "solvers/linear <hash>" behind
  /// "solvers/linear"; cmake/fit_rooms.txt has the rooms.
  std::map<std::string, std::string> fit_codes;
  std::string record_code;  ///< of what scores and times depend on: those, bench/{score,run,...}
  std::string limit_code;   ///< of what limits depend on: core/, forward/, bench/{limit,score,...}
};

/// Of the running program.
const Build& this_build();

/// "0123456789ab", with "-dirty" where sources had changed.
std::string commit_text(const std::string& commit, bool dirty);

/// The folder of the sources that the program was built from: where the program lies in a build
/// folder of it, wherever that was moved to, the folder above; else where it was when it was built.
std::filesystem::path project_folder();

}  // namespace ertbench
