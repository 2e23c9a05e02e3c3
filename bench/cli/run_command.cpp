#include <CLI/CLI.hpp>

#include "bench/charts/chart_types.h"
#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/run/runner.h"
#include "core/errors.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct RunArguments {
  std::string experiment;
  std::string out;
  std::vector<std::string> only;
  int jobs = cores();
  bool fresh = false;
  bool rebuild_stale = false;
};

ExitCode run(const RunArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  RunOptions options;
  options.out = result_folder(arguments.out, experiment.name);
  options.only = arguments.only;
  options.jobs = arguments.jobs;
  options.fresh = arguments.fresh;
  std::vector<std::string> labels;
  for (const auto& trials : experiment.rows()) labels.push_back(trials.front().label);
  for (const std::string& label : options.only) {
    const bool known =
        std::any_of(experiment.solvers.begin(), experiment.solvers.end(),
                    [&](const SolverEntry& e) { return e.label == label || e.family == label; });
    if (!known) {
      throw InputError("--only: no solver is labelled \"" + printable(label) + "\" in " +
                       arguments.experiment + "; there are " + list_of(labels));
    }
  }
  const Cache cache =
      Cache::standard().with(arguments.rebuild_stale ? Reuse::same_program : Reuse::same_code);
  const ExperimentResults results = run_experiment(experiment, cache, options);
  const std::size_t undrawn = report_experiment(experiment, cache, results, options.out);
  return results.failures > 0 || undrawn > 0 ? trial_failed : done;
}

}  // namespace

Action add_run(CLI::App& command) {
  const auto arguments = std::make_shared<RunArguments>();
  command.description("Run an experiment: data, solvers, tables, figures");
  add_experiment(command, arguments->experiment);
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT)");
  command
      .add_option("--only", arguments->only,
                  "Run only the solvers of these labels (all their seeds; the\n"
                  "label of a sweep stands for all of it)")
      ->delimiter(',');
  command
      .add_option("--jobs", arguments->jobs,
                  "Trials fitted and scored at a time, the cores shared out among them\n"
                  "(default: one for each core; timings always run alone)")
      ->check(CLI::Range(1, 256));
  command.add_flag("--fresh", arguments->fresh, "Fit and measure again what is finished already");
  command.add_flag("--rebuild-stale", arguments->rebuild_stale,
                   "Make again what another build of the program made, even where nothing\n"
                   "that it depends on has changed since; what depends on it always is");
  command.footer(
      "Example:\n  ertbench run experiments/table_c1.json --only tsvd,pdipm --jobs 2\n"
      "Solvers with \"seeds\" are trained once for each; charts of their training are in\n"
      "RESULTS/training/. The file's \"charts\" are drawn beside the table. With \"ladders\" each\n"
      "solver is taken to where it breaks down: RESULTS/breakdown.md, breakdown.csv and charts.");
  return [arguments] { return run(*arguments); };
}

}  // namespace ertbench
