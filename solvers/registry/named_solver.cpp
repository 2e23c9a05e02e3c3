#include "solvers/registry/named_solver.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/kept.h"
#include "forward/sheet/sensor_json.h"
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

namespace {

/// Whether the fit follows from the entry and the sensor alone.
bool needs_no_files(const NamedSolver& named, const FitInput& input,
                    const SolverRegistry& registry) {
  const std::string type = named.entry->value("type", "");
  const SolverInfo* const info = registry.find_known(type);
  if (!info || registry.is_of_plugin(type) || input.training || input.validation) return false;
  return !named.entry->contains("checkpoint") &&
         std::none_of(info->parameters.begin(), info->parameters.end(),
                      [&](const ParameterInfo& parameter) {
                        return parameter.role == ParameterRole::file &&
                               named.entry->contains(parameter.name);
                      });
}

}  // namespace

std::unique_ptr<Solver> fitted_solver(const NamedSolver& named, const FitInput& input,
                                      SolverRegistry& registry) {
  std::unique_ptr<Solver> solver;
  const auto make = [&] { solver = registry.make(JsonObject(*named.entry, named.source, "")); };
  const auto fit = [&] {
    make();
    try {
      solver->fit(input);
    } catch (const InputError& e) {
      const std::string message = e.what();
      if (message.starts_with(named.source + ": ")) throw;  // a parameter, with its place
      throw InputError(named.source + ": " + message);
    }
  };
  if (!needs_no_files(named, input, registry)) {
    fit();
    return solver;
  }
  const auto load = [&](const fs::path& file) {
    make();
    solver->load(file, input.sensor);
  };
  keep("fit-" + named.entry->value("type", ""), json{*named.entry, to_json(input.sensor)}.dump(),
       load, fit, [&](const fs::path& file) { solver->save(file); });
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
