#include "solvers/registry/plugin_library.h"

#include <dlfcn.h>

#include <cstdlib>
#include <sstream>

#include "core/errors.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

template <typename Function>
Function* entry_point(void* handle, const std::filesystem::path& library, const char* name) {
  void* const symbol = dlsym(handle, name);
  if (!symbol) {
    throw InputError(library.string() + ": is not a library of ertbench solvers: it has no " +
                     name);
  }
  return reinterpret_cast<Function*>(symbol);
}

}  // namespace

std::vector<std::filesystem::path> plugin_folders() {
  std::vector<std::filesystem::path> folders;
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (!error) {
    folders.push_back(program.parent_path());
    folders.push_back((program.parent_path() / ERTBENCH_INSTALLED_PLUGINS).lexically_normal());
  }
  if (const char* listed = std::getenv("ERTBENCH_PLUGINS")) {
    std::istringstream in(listed);
    for (std::string folder; std::getline(in, folder, ':');) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  return folders;
}

void register_plugin(const std::filesystem::path& library, SolverRegistry& registry) {
  // An absolute name: dlopen looks for a bare one in the system's folders.
  void* const handle = dlopen(std::filesystem::absolute(library).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw InputError(library.string() + ": cannot be loaded: " + dlerror());
  const int version = entry_point<int()>(handle, library, "ertbench_solver_interface")();
  if (version != solver_interface_version) {
    throw InputError(library.string() + ": was built for version " + std::to_string(version) +
                     " of the solver interface, this program has version " +
                     std::to_string(solver_interface_version) + "; build it anew");
  }
  entry_point<void(SolverRegistry&)>(handle, library, "ertbench_register_solvers")(registry);
}

}  // namespace ertbench
