#include <CLI/CLI.hpp>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/report/fidelity_report.h"
#include "bench/run/fidelity.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct FidelityArguments {
  std::string experiment;
  std::string out;
  int scenes = 500;
};

ExitCode fidelity(const FidelityArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, SolverCheck::none);
  report_fidelity(experiment, measure_fidelity(experiment, arguments.scenes),
                  result_folder(arguments.out, experiment.name));
  return done;
}

}  // namespace

Action add_fidelity(CLI::App& command) {
  const auto arguments = std::make_shared<FidelityArguments>();
  command.description("Error and time of the forward models on an experiment's scenes");
  add_experiment(command, arguments->experiment);
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT)");
  command.add_option("--scenes", arguments->scenes, "Scenes of each dataset (default: 500)")
      ->check(CLI::Range(10, 1000000));
  command.footer(
      "Example:\n  ertbench fidelity experiments/fidelity.json --scenes 200\n"
      "\"grid\": \"auto\" against the grids of 24, 48, 96 and 192, one thread: how long a scene\n"
      "takes, how far its voltages are from the converged ones, and how often the estimate of\n"
      "\"auto\" promised too much.");
  return [arguments] { return fidelity(*arguments); };
}

}  // namespace ertbench
