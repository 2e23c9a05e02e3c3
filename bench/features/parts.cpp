#include "bench/features/parts.h"

#include <dlfcn.h>

#include <filesystem>
#include <map>

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// The folder of the library that this function is in.
fs::path own_folder() {
  Dl_info info;
  if (!dladdr(reinterpret_cast<const void*>(&part_named), &info)) return {};
  return fs::absolute(info.dli_fname).parent_path();
}

Part loaded(const std::string& name) {
  const std::string library = "libertbench_" + name + ".so";
  fs::path file = own_folder() / library;
  if (!fs::exists(file)) file = own_folder() / "ertbench" / library;
  if (!fs::exists(file)) throw PartMissing(name);
  void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw std::runtime_error(file.string() + ": cannot be loaded: " + dlerror());
  const auto fill =
      reinterpret_cast<void (*)(Part&)>(dlsym(handle, ("ertbench_part_" + name).c_str()));
  if (!fill) throw std::runtime_error(file.string() + ": is no part of this program");
  Part part;
  fill(part);
  return part;
}

}  // namespace

PartMissing::PartMissing(const std::string& part)
    : std::runtime_error("the part \"" + part +
                         "\" of the program is not built; build the target ertbench_" + part),
      part_(part) {}

const Part& part_named(const std::string& name) {
  static std::map<std::string, Part> parts;
  const auto found = parts.find(name);
  return found != parts.end() ? found->second : parts.emplace(name, loaded(name)).first->second;
}

}  // namespace ertbench
