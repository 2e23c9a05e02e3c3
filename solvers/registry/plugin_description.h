#pragma once

#include <functional>
#include <string>
#include <vector>

#include "solvers/solver_info.h"

namespace ertbench {

/// What a shared library of solvers says of itself. All of it without SolverInfo::make: the
/// solvers themselves are in another process, and made where the library is loaded.
struct PluginDescription {
  std::vector<SolverType> types;
  /// Where the library is refused in an orderly way: the message of the InputError.
  std::string refused;
  /// Where it took its process down, threw anything else or did not come back: how.
  std::string failed;
};

/// Has `load` load a library in a process of its own, which passes on what types it brought.
PluginDescription describe_in_child(const std::function<std::vector<SolverType>()>& load);

/// Seconds that loading a library may take, and after that making one solver of it.
inline constexpr double plugin_time_limit_s = 60;

}  // namespace ertbench
