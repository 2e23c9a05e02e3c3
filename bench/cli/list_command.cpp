#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/score/metric_table.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/json_text.h"
#include "core/nearest_word.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::size_t most_described = 1000;  ///< characters of a plugin's own words

struct ListArguments {
  std::string type;
  bool as_json = false;
};

void print_solver(SolverRegistry& registry, const std::string& type) {
  const SolverInfo* info = registry.find(type);
  if (!info) {
    std::printf("\n  %s\n      not available: its plugin is not built\n", type.c_str());
    return;
  }
  std::printf("\n  %s\n      %s\n", type.c_str(), printable(info->summary, most_described).c_str());
  for (const ParameterInfo& parameter : info->parameters) {
    std::printf("      \"%s\": %s\n", printable(parameter.name).c_str(),
                printable(parameter.description, most_described).c_str());
  }
}

json json_of_solver(SolverRegistry& registry, const std::string& type) {
  const SolverInfo* info = registry.find(type);
  if (!info) return {{"type", type}, {"available", false}};
  json parameters = json::array();
  for (const ParameterInfo& parameter : info->parameters) {
    parameters.push_back({{"name", parameter.name},
                          {"description", parameter.description},
                          {"inference", parameter.role == ParameterRole::inference}});
  }
  return {{"type", type},
          {"available", true},
          {"summary", info->summary},
          {"seeded", info->has_seed()},
          {"parameters", parameters}};
}

std::vector<fs::path> experiment_files() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(project_folder() / "experiments")) {
    if (entry.path().extension() == ".json" && entry.path().filename() != "schema.json") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// The types asked for: all, or one. Throws InputError where there is no such type.
std::vector<std::string> types_of(const SolverRegistry& registry, const std::string& type) {
  std::vector<std::string> all = registry.types();
  if (type.empty()) return all;
  if (std::find(all.begin(), all.end(), type) != all.end()) return {type};
  const std::string near = nearest_word(type, all);
  throw InputError("no solver has the type \"" + printable(type) + "\"" +
                   (near.empty() ? "" : "; did you mean \"" + near + "\"?") + "; there are " +
                   list_of(all));
}

void print_metrics_and_experiments(SolverRegistry& registry) {
  std::printf("\nMetrics (δσ: the change of the conductivity; * may be chosen as an error):\n\n");
  for (const MetricEntry& entry : kMetricTable) {
    std::printf("  %s%s: %s\n", entry.name, is_error(entry) ? "*" : "", entry.legend);
  }
  std::printf("\nExperiments:\n");
  for (const fs::path& file : experiment_files()) {
    std::string question;
    try {
      question = read_experiment(file, registry, {}, SolverCheck::none).question;
    } catch (const InputError& error) {
      question = std::string("cannot be used: ") + error.what();
    }
    std::printf("\n  experiments/%s\n      %s\n", printable_path(file.filename().string()).c_str(),
                printable(question).c_str());
  }
}

void print_json(SolverRegistry& registry, const ListArguments& arguments) {
  json out = {{"solvers", json::array()}};
  for (const std::string& type : types_of(registry, arguments.type)) {
    out["solvers"].push_back(json_of_solver(registry, type));
  }
  if (arguments.type.empty()) {
    for (const MetricEntry& entry : kMetricTable) {
      out["metrics"].push_back(
          {{"name", entry.name}, {"legend", entry.legend}, {"error", is_error(entry)}});
    }
    for (const fs::path& file : experiment_files()) {
      json& entry = out["experiments"].emplace_back();
      entry["file"] = "experiments/" + file.filename().string();
      try {
        const Experiment experiment = read_experiment(file, registry, {}, SolverCheck::none);
        entry["title"] = experiment.title;
        entry["question"] = experiment.question;
      } catch (const InputError& error) {
        entry["error"] = error.what();
      }
    }
  }
  std::printf("%s\n", json_text(printable_json(out, most_described), 2).c_str());
}

ExitCode list(const ListArguments& arguments) {
  SolverRegistry registry;
  if (arguments.as_json) {
    print_json(registry, arguments);
    return done;
  }
  const std::vector<std::string> types = types_of(registry, arguments.type);
  std::printf("Solvers (\"type\" in an experiment's \"solvers\" list):\n");
  for (const std::string& type : types) print_solver(registry, type);
  if (arguments.type.empty()) print_metrics_and_experiments(registry);
  return done;
}

}  // namespace

Action add_list(CLI::App& command) {
  const auto arguments = std::make_shared<ListArguments>();
  command.description("Solvers with their parameters; metrics; experiments");
  command.add_option("TYPE", arguments->type, "Only the solver of this type");
  command.add_flag("--json", arguments->as_json, "For programs");
  command.footer("Examples:\n  ertbench list\n  ertbench list dd-ert --json");
  return [arguments] { return list(*arguments); };
}

}  // namespace ertbench
