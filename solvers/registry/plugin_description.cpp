#include "solvers/registry/plugin_description.h"

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json_text.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {
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

}  // namespace ertbench
