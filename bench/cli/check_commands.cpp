#include <CLI/CLI.hpp>

#include "bench/check/baseline.h"
#include "bench/check/check.h"
#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/record/cache.h"
#include "bench/run/runner.h"
#include "bench/run/timing_stage.h"
#include "bench/speed/timing.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct CheckArguments {
  std::string experiment;
  CheckOptions options;
};

ExitCode check(const CheckArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  return check_experiment(experiment, registry, arguments.options) ? done : regression;
}

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

Action add_check(CLI::App& command) {
  const auto arguments = std::make_shared<CheckArguments>();
  CheckOptions& options = arguments->options;
  options.jobs = usable_cores();
  add_experiment(command, arguments->experiment);
  command.add_flag("--update", options.update, "Write the baseline anew, and say what changed");
  command
      .add_flag("--images", options.images,
                "Only hold stored networks and short trainings to their images: seconds")
      ->excludes("--update");
  command
      .add_option("--seeds", options.seeds,
                  "With --update: training seeds behind the interval of a learned solver\n"
                  "(default: \"baseline_seeds\" of the experiment's \"check\"; without it\n"
                  "those of the entry if 5 or more, else 8)")
      ->check(CLI::Range(least_seeds, most_seeds));
  command.add_flag("--accept-coarse", options.accept_coarse,
                   "With --update: write a baseline that would let a learned solver become worse\n"
                   "by more than 10 % of relative_error or RIE, 0.03 of AR or 25 % of PE");
  command.add_flag("--all", options.all, "Show every quantity, not just what changed");
  command.add_flag("--warn-times", options.warn_times,
                   "Only warn about times, as on another cpu: for shared machines");
  command.add_flag("--reuse", options.reuse,
                   "Take what `run` left in the cache and in results/EXPERIMENT: quick, but\n"
                   "blind to changes of the program since");
  command.add_option("--baseline", options.baseline,
                     "Baseline (default: results/baselines/EXPERIMENT.json)");
  command.add_option("--out", options.out, "Result folder (default: results/EXPERIMENT/check)");
  command.add_option("--jobs", options.jobs, "Trials fitted and scored at a time, as in `run`")
      ->check(CLI::Range(1, 256));
  command.footer(
      "Example:\n  ertbench check experiments/quick.json\n"
      "Everything is made anew by this very program, in a cache of its own; a check that was cut\n"
      "off goes on where it stopped. Exit code 1 where something is worse, slower or missing.\n"
      "Times are multiples of a calibration loop, and only warned about on another cpu.");
  return [arguments] { return check(*arguments); };
}

Action add_timing(CLI::App& command) {
  const auto options = std::make_shared<TimingOptions>();
  command.add_option("FILTER", options->filter,
                     "Regular expression of names; default: all, several minutes");
  command.add_option("--out", options->out, "JSON file to write (default: results/timing.json)");
  command
      .add_option("--rounds", options->rounds,
                  "Rounds of all benchmark programs, of which the median counts (default: 3)")
      ->check(CLI::Range(1, 99));
  command.footer(
      "Example:\n  ertbench timing 'reconstruct/(tsvd|fcnn)' --out timing.json\n"
      "The machine should be otherwise idle. \"0.80 of stream\" means that the least time this\n"
      "machine allows, here for reading the matrices once, is 0.80 of what was measured.");
  return [options] { return run_timing(*options) > 0 ? trial_failed : done; };
}

Action add_fidelity(CLI::App& command) {
  const auto arguments = std::make_shared<FidelityArguments>();
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
