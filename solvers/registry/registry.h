#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "solvers/registry/plugin.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// The solvers that an experiment can name. Those of plugins, the learned ones among them, are code
/// that we do not run in the process that runs an experiment: there they are known by what a child
/// process says of them (`find`), and made in processes of their own alone (`make`, after
/// `allow_plugins`).
class SolverRegistry {
 public:
  SolverRegistry();  ///< the built-in solvers, and where the learned ones are to be found

  /// Adds to `info` the parameters that all solvers share. Throws InputError where the type is
  /// there already, or what it says of its parameters does not go together.
  void add(const std::string& type, SolverInfo info);
  /// Declares that `type` comes from the shared library `library`, looked for in the folder of the
  /// program and in those of $ERTBENCH_PLUGINS (separated by ':').
  void add_plugin_type(const std::string& type, const std::string& library);
  /// Names a library of the user's own solvers. What types it has is asked when it matters.
  void add_library(const std::filesystem::path& library);
  /// Asks the user's libraries, each in a process of its own, what types they have. Throws
  /// InputError where one cannot be loaded or has a type that is taken; one that takes its process
  /// down is noted, see unusable_libraries.
  void describe_libraries();

  /// From now on `make` may load plugins into this process, which is there for nothing else.
  void allow_plugins() { plugins_allowed_ = true; }
  /// Loads a shared library with the entry point `ertbench_register_solvers` into this process.
  /// Throws InputError with the loader's message where that fails.
  void load_plugin(const std::filesystem::path& library);

  /// The type's registration, whose plugin is loaded into this process where that has not happened.
  /// Throws InputError for an unknown type or an unusable plugin, std::logic_error where plugins
  /// are not allowed.
  const SolverInfo& load(const std::string& type);

  /// Makes a solver from `{"type": ..., "label": ..., ...}`, inside a CheckedSolver. Throws
  /// InputError with the JSON path for an unknown type or parameter, else as `load`.
  std::unique_ptr<Solver> make(JsonObject spec);

  /// All that can be named, in order; of the user's libraries, what is known so far.
  std::vector<std::string> types() const { return order_; }
  /// Null where the type is unknown, or its plugin absent or unusable. Of a plugin that is not
  /// loaded here it is what a child process says, without SolverInfo::make.
  const SolverInfo* find(const std::string& type);
  /// The same, without asking a plugin: null also where that has not happened yet.
  const SolverInfo* find_known(const std::string& type) const;
  /// Whether its solvers come from a plugin.
  bool is_of_plugin(const std::string& type) const { return plugin_of_.count(type) > 0; }

  /// A library of the user's that took its process down, or did not come back.
  struct UnusableLibrary {
    std::filesystem::path file;
    std::string how;
  };
  std::span<const UnusableLibrary> unusable_libraries() const { return unusable_; }

 private:
  /// Where the type's library is. Throws InputError where there is none, or no such type.
  std::filesystem::path library_of(const std::string& type) const;
  /// Has a child process load the library and notes what it brought.
  void describe(const std::filesystem::path& library);

  std::vector<std::string> order_;
  std::map<std::string, SolverInfo> solvers_;               ///< of this process
  std::map<std::string, SolverInfo> described_;             ///< of plugins that are not loaded here
  std::map<std::string, std::filesystem::path> plugin_of_;  ///< absolute, or a bare name
  std::vector<std::filesystem::path> not_described_;        ///< the user's libraries
  std::vector<UnusableLibrary> unusable_;
  bool plugins_allowed_ = false;
};

/// The version that a plugin must have been built against.
inline constexpr int solver_interface_version = ERTBENCH_SOLVER_INTERFACE;

}  // namespace ertbench

/// Stands once in a plugin, outside of any namespace, beside its entry point
///     extern "C" void ertbench_register_solvers(ertbench::SolverRegistry&)
/// It says what the plugin was built for and with, which is compared before anything of it is
/// called.
#define ERTBENCH_SOLVER_PLUGIN                                                               \
  extern "C" __attribute__((used, visibility("default"))) const char ertbench_plugin_abi[] = \
      ERTBENCH_PLUGIN_ABI;                                                                   \
  extern "C" int ertbench_solver_interface() { return ERTBENCH_SOLVER_INTERFACE; }
