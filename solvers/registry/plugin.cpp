#include "solvers/registry/plugin.h"

#include <dlfcn.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

/// The parts of an ABI text by their names.
std::map<std::string, std::string> abi_parts(const std::string& text) {
  std::map<std::string, std::string> parts;
  const std::string mark = ERTBENCH_PLUGIN_ABI_MARK;
  const std::string list = text.starts_with(mark) ? text.substr(mark.size()) : text;
  for (const std::string& one : split(list, ";")) {
    const std::size_t equals = one.find('=');
    if (equals != std::string::npos) parts[one.substr(0, equals)] = one.substr(equals + 1);
  }
  return parts;
}

}  // namespace

std::string program_abi() { return ERTBENCH_PLUGIN_ABI; }

std::string abi_difference(const std::string& plugin) {
  if (plugin == program_abi()) return {};
  const std::map<std::string, std::string> ours = abi_parts(program_abi());
  std::map<std::string, std::string> theirs = abi_parts(plugin);
  std::string out;
  for (const auto& [name, value] : ours) {
    const auto found = theirs.find(name);
    const std::string other =
        found == theirs.end() ? "that it does not say" : printable(found->second);
    if (other == value) continue;
    out += out.empty() ? "" : "; ";
    out += name;
    out += " ";
    out += other;
    out += ", here ";
    out += value;
  }
  return out.empty() ? "a text of another form" : out;
}

namespace {

using nlohmann::json;

json to_json(const SolverType& type) {
  json parameters = json::array();
  for (const ParameterInfo& one : type.info.parameters) {
    parameters.push_back({one.name, one.description, static_cast<int>(one.role)});
  }
  return {{"name", type.name},
          {"summary", type.info.summary},
          {"parameters", std::move(parameters)},
          {"comparison", static_cast<int>(type.info.comparison)},
          {"break_even_reference", type.info.break_even_reference}};
}

SolverType solver_type_from_json(const json& value) {
  SolverType type{value.at("name"), {value.at("summary"), {}, {}, {}, {}}};
  for (const json& one : value.at("parameters")) {
    type.info.parameters.push_back(
        {one.at(0), one.at(1), static_cast<ParameterRole>(one.at(2).get<int>())});
  }
  type.info.comparison = static_cast<ImageComparison>(value.at("comparison").get<int>());
  type.info.break_even_reference = value.at("break_even_reference");
  return type;
}

/// What the child has to say; it does not throw.
json said_of(const std::function<std::vector<SolverType>()>& load) {
  try {
    json types = json::array();
    for (const SolverType& type : load()) types.push_back(to_json(type));
    return {{"types", std::move(types)}};
  } catch (const InputError& error) {
    return {{"refused", error.what()}};
  } catch (const std::exception& error) {
    return {{"failed", std::string("threw an exception: ") + error.what()}};
  } catch (...) {
    return {{"failed", "threw what is no exception"}};
  }
}

}  // namespace

PluginDescription describe_in_child(const std::function<std::vector<SolverType>()>& load) {
  const IsolatedOutcome outcome =
      run_isolated([&](const auto& send) { send(json_text(said_of(load))); },
                   {plugin_time_limit_s, machine_memory_bytes() / 2});
  PluginDescription description;
  if (!outcome.finished || outcome.messages.empty()) {
    description.failed = "ended its process (" + outcome.end.text() + ")";
    return description;
  }
  const json said = parse_json(outcome.messages.front(), "what a plugin said");
  description.refused = said.value("refused", "");
  description.failed = printable(said.value("failed", ""));
  const json types = printable_json(said.value("types", json::array()), 2000);
  for (const json& type : types) {
    description.types.push_back(solver_type_from_json(type));
  }
  return description;
}

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
  require_regular_file(library);  // dlopen would wait at a pipe for ever
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
