#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "solvers/solver.h"

namespace ertbench {

class JsonObject;

/// One parameter of a solver, for `ertbench list` and for messages. One whose name begins with
/// "inference_" says how a fitted solver is applied and must have no part in `fit` or in the fitted
/// file, which solvers that differ by such parameters alone share.
struct ParameterInfo {
  std::string name;
  std::string description;  ///< values, default, unit
};

struct SolverInfo {
  std::string summary;  ///< one line, with the formula or the source
  std::vector<ParameterInfo> parameters;
  /// Reads its own keys from the object ("type" and "label" are taken already) and calls `finish`.
  std::function<std::unique_ptr<Solver>(JsonObject)> make;
  /// Whether other solvers' costs are held against its own unless an experiment says otherwise.
  bool yardstick = false;
};

/// The solvers that an experiment can name. Types that live in a plugin are known by name and the
/// plugin is loaded when one of them is first made.
class SolverRegistry {
 public:
  SolverRegistry();  ///< the built-in solvers, and where the learned ones are to be found

  /// Throws InputError where the type is there already.
  void add(const std::string& type, SolverInfo info);
  /// Declares that `type` comes from the shared library `library`, looked for in the folder of the
  /// program and in those of $ERTBENCH_PLUGINS (separated by ':').
  void add_plugin_type(const std::string& type, const std::string& library);
  /// Loads a shared library with the entry point `ertbench_register_solvers`. Throws InputError
  /// with the loader's message where that fails.
  void load_plugin(const std::filesystem::path& library);

  /// Makes a solver from `{"type": ..., "label": ..., ...}`. Throws InputError with the JSON path
  /// for an unknown type or parameter.
  std::unique_ptr<Solver> make(JsonObject spec);

  std::vector<std::string> types() const { return order_; }  ///< all that can be named, in order
  /// Null where the type is unknown, or its plugin absent or unusable.
  const SolverInfo* find(const std::string& type);

 private:
  /// Loads the type's plugin where that has not happened. Throws InputError.
  const SolverInfo& require(const std::string& type);

  std::vector<std::string> order_;
  std::map<std::string, SolverInfo> solvers_;
  std::map<std::string, std::string> plugin_of_;
};

/// The version that a plugin must have been built against.
inline constexpr int solver_interface_version = 3;

/// Entry points of a plugin; the first returns solver_interface_version:
///     extern "C" int ertbench_solver_interface();
///     extern "C" void ertbench_register_solvers(ertbench::SolverRegistry&);

}  // namespace ertbench
