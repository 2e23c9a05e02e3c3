#include "solvers/registry/plugin_abi.h"

#include <map>

#include "core/text.h"

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

}  // namespace ertbench
