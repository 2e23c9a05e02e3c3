#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ertbench {

class SolverRegistry;

/// Folders in which plugins are looked for: that of the running program, that of the learned
/// solvers where it is installed, then those of $ERTBENCH_PLUGINS, separated by ':'.
std::vector<std::filesystem::path> plugin_folders();

/// Opens a shared library of solvers, checks the interface it was built against and lets it
/// register its solvers. It stays open until the program ends. Throws InputError.
void register_plugin(const std::filesystem::path& library, SolverRegistry& registry);

}  // namespace ertbench
