#include <CLI/CLI.hpp>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/run/runner.h"
#include "bench/run/stages.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct FidelityArguments {
  std::string experiment;
  std::string out;
  int scenes = fidelity_usual_scenes;
  bool fresh = false;
  bool rebuild_stale = false;
};

ExitCode fidelity(const FidelityArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment =
      read_experiment(arguments.experiment, registry, {}, SolverCheck::none);
  RunOptions options;
  options.out = result_folder(arguments.out, experiment.name);
  options.fresh = arguments.fresh;
  const Stages stages = stages_of_fidelity(arguments.scenes);
  const Cache cache =
      Cache::standard().with(arguments.rebuild_stale ? Reuse::same_program : Reuse::same_code);
  const ExperimentResults results = run_stages(stages, experiment, cache, options);
  report_stages(stages, experiment, results, options.out);
  return results.failures > 0 ? trial_failed : done;
}

}  // namespace

Action add_fidelity(CLI::App& command) {
  const auto arguments = std::make_shared<FidelityArguments>();
  command.description("Error and time of the forward models on an experiment's scenes");
  add_experiment(command, arguments->experiment);
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT)");
  command.add_option("--scenes", arguments->scenes, "Scenes of each dataset (default: 500)")
      ->check(CLI::Range(10, 1000000));
  command.add_flag("--fresh", arguments->fresh, "Measure again what is finished already");
  command.add_flag("--rebuild-stale", arguments->rebuild_stale,
                   "Measure again what another build of the program measured");
  command.footer(
      "Example:\n  ertbench fidelity experiments/fidelity.json --scenes 200\n"
      "\"grid\": \"auto\" against the grids of 24, 48, 96 and 192, one thread: how long a scene\n"
      "takes, how far its voltages are from the converged ones, and how often the estimate of\n"
      "\"auto\" promised too much. A dataset that is finished is not measured again.");
  return [arguments] { return fidelity(*arguments); };
}

}  // namespace ertbench
