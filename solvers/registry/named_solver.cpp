#include "solvers/registry/named_solver.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "solvers/check/stored_solver.h"
#include "solvers/registry/registry.h"

namespace ertbench {

namespace fs = std::filesystem;
using nlohmann::json;

NamedSolver read_named_solver(const std::string& file_or_name) {
  std::error_code absent;
  if (fs::exists(file_or_name, absent) || file_or_name.ends_with(".json")) {
    return {read_json_file(file_or_name), file_or_name};
  }
  const fs::path fitted = fitted_file(file_or_name, "");
  const std::string source = fs::path(fitted).replace_extension(".json").string();
  const json card = read_json_file(source);
  return {json{{"type", JsonObject(card, source, "").text("type")},
               {"label", file_or_name},
               {"checkpoint", fitted.filename().string()}},
          source};
}

std::unique_ptr<Solver> fitted_solver(const NamedSolver& named, const FitInput& input,
                                      SolverRegistry& registry) {
  std::unique_ptr<Solver> solver = registry.make(JsonObject(*named.entry, named.source, ""));
  try {
    solver->fit(input);
  } catch (const InputError& e) {
    throw InputError(named.source + ": " + e.what());
  }
  return solver;
}

void blame_plugin(const std::string& file_or_name, const fs::path& plugin,
                  const std::exception& error) {
  if (plugin.empty()) return;
  const std::string type = read_named_solver(file_or_name).entry->value("type", "");
  const SolverRegistry ours;
  if (ours.is_of_plugin(type) || ours.find_known(type)) return;
  throw InputError(plugin.string() + ": its solver \"" + type +
                   "\" threw an exception: " + error.what() + "; ask its authors");
}

}  // namespace ertbench
