#include "solvers/registry/plugin_library.h"

#include <dlfcn.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/errors.h"
#include "solvers/registry/plugin_abi.h"
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

/// What the library says that it was built with, read out of its file: loading it would already
/// run its initialisers. Empty where it says nothing.
std::string abi_in_file(const std::filesystem::path& library) {
  constexpr std::uintmax_t most_bytes = std::uintmax_t{1} << 30U;
  constexpr std::size_t most_text = 1000;
  std::error_code error;
  if (!std::filesystem::is_regular_file(library, error)) return {};
  if (std::filesystem::file_size(library, error) > most_bytes || error) return {};
  std::ifstream in(library, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  // The mark may also stand alone, as it does in this library.
  for (std::size_t at = 0; (at = bytes.find(ERTBENCH_PLUGIN_ABI_MARK, at)) != std::string::npos;
       ++at) {
    const std::string_view text(bytes.c_str() + at);
    if (text.ends_with(';') && text.size() < most_text) return std::string(text);
  }
  return {};
}

void require_same_abi(const std::filesystem::path& library, const std::string& text) {
  const std::string difference = abi_difference(text);
  if (difference.empty()) return;
  throw InputError(library.string() + ": was built otherwise than this program: " + difference +
                   "; build it with the flags that find_package(ertbench) hands on");
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
  if (const std::string abi = abi_in_file(library); !abi.empty()) require_same_abi(library, abi);
  // An absolute name: dlopen looks for a bare one in the system's folders.
  void* const handle = dlopen(std::filesystem::absolute(library).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw InputError(library.string() + ": cannot be loaded: " + dlerror());
  const int version = entry_point<int()>(handle, library, "ertbench_solver_interface")();
  if (version != solver_interface_version) {
    throw InputError(library.string() + ": was built for version " + std::to_string(version) +
                     " of the solver interface, this program has version " +
                     std::to_string(solver_interface_version) + "; build it anew");
  }
  const void* const abi = dlsym(handle, "ertbench_plugin_abi");
  if (!abi) {
    throw InputError(library.string() +
                     ": does not say what it was built with; put ERTBENCH_SOLVER_PLUGIN "
                     "(solvers/registry/registry.h) into it and build it anew");
  }
  require_same_abi(library, static_cast<const char*>(abi));
  entry_point<void(SolverRegistry&)>(handle, library, "ertbench_register_solvers")(registry);
}

}  // namespace ertbench
