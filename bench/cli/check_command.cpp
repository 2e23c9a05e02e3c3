#include "bench/check/check_command.h"

#include <CLI/CLI.hpp>

#include "bench/charts/chart_types.h"
#include "bench/check/baseline.h"
#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/run/machine_load.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct CheckArguments {
  std::string experiment;
  std::string out;
  std::string baseline;
  int jobs = usable_cores();
  bool all = false;
  bool update = false;
  bool images = false;
  bool reuse = false;
  bool warn_times = false;
  bool accept_coarse = false;
  std::optional<int> seed_count;
};

ExitCode check(const CheckArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  CheckOptions options;
  options.out = arguments.out;
  options.baseline = arguments.baseline;
  options.jobs = arguments.jobs;
  options.all = arguments.all;
  options.images = arguments.images;
  options.update = arguments.update;
  options.seeds = arguments.seed_count;
  options.reuse = arguments.reuse;
  options.accept_coarse = arguments.accept_coarse;
  options.warn_times = arguments.warn_times;
  return check_experiment(experiment, registry, options) ? done : regression;
}

}  // namespace

Action add_check(CLI::App& command) {
  const auto arguments = std::make_shared<CheckArguments>();
  command.description("Run an experiment and compare with its baseline");
  add_experiment(command, arguments->experiment);
  command.add_flag("--update", arguments->update, "Write the baseline anew, and say what changed");
  command
      .add_flag("--images", arguments->images,
                "Only hold stored networks and short trainings to their images: seconds")
      ->excludes("--update");
  command
      .add_option("--seeds", arguments->seed_count,
                  "With --update: training seeds behind the interval of a learned solver\n"
                  "(default: \"baseline_seeds\" of the experiment's \"check\"; without it\n"
                  "those of the entry if 5 or more, else 8)")
      ->check(CLI::Range(least_seeds, most_seeds));
  command.add_flag("--accept-coarse", arguments->accept_coarse,
                   "With --update: write a baseline that would let a learned solver become worse\n"
                   "by more than 10 % of relative_error or RIE, 0.03 of AR or 25 % of PE");
  command.add_flag("--all", arguments->all, "Show every quantity, not just what changed");
  command.add_flag("--warn-times", arguments->warn_times,
                   "Only warn about times, as on another cpu: for shared machines");
  command.add_flag("--reuse", arguments->reuse,
                   "Take what `run` left in the cache and in results/EXPERIMENT: quick, but\n"
                   "blind to changes of the program since");
  command.add_option("--baseline", arguments->baseline,
                     "Baseline (default: results/baselines/EXPERIMENT.json)");
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT/check)");
  command.add_option("--jobs", arguments->jobs, "Trials fitted and scored at a time, as in `run`")
      ->check(CLI::Range(1, 256));
  command.footer(
      "Example:\n  ertbench check experiments/quick.json\n"
      "Everything is made anew by this very program, in a cache of its own; a check that was cut\n"
      "off goes on where it stopped. Exit code 1 where something is worse, slower or missing.\n"
      "Times are multiples of a calibration loop, and only warned about on another cpu.");
  return [arguments] { return check(*arguments); };
}

}  // namespace ertbench
