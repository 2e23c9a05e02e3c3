#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/score/metric_table.h"
#include "core/build.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

ExitCode list() {
  SolverRegistry registry;
  std::printf("Solvers (\"type\" in an experiment's \"solvers\" list):\n");
  for (const std::string& type : registry.types()) {
    const SolverInfo* info = registry.find(type);
    if (!info) {
      std::printf("\n  %s\n      not available: its plugin is not built\n", type.c_str());
      continue;
    }
    std::printf("\n  %s\n      %s\n", type.c_str(), printable(info->summary, 1000).c_str());
    for (const ParameterInfo& parameter : info->parameters) {
      std::printf("      \"%s\": %s\n", printable(parameter.name).c_str(),
                  printable(parameter.description, 1000).c_str());
    }
  }
  std::printf("\nMetrics (δσ: the change of the conductivity; * may be chosen as an error):\n\n");
  for (const MetricEntry& entry : kMetricTable) {
    std::printf("  %s%s: %s\n", entry.name, is_error(entry) ? "*" : "", entry.legend);
  }
  std::printf("\nExperiments:\n");
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(project_folder() / "experiments")) {
    if (entry.path().extension() == ".json" && entry.path().filename() != "schema.json") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    const Experiment experiment = read_experiment(file, registry, {}, SolverCheck::none);
    std::printf("\n  experiments/%s\n      %s\n", printable_path(file.filename().string()).c_str(),
                printable(experiment.question).c_str());
  }
  return done;
}

}  // namespace

Action add_list(CLI::App& command) {
  command.description("Solvers with their parameters; metrics; experiments");
  command.footer("Example:\n  ertbench list");
  return list;
}

}  // namespace ertbench
