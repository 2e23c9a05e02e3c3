#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/publish/clocks.h"
#include "bench/publish/publish.h"
#include "bench/publish/publish_plan.h"
#include "bench/publish/published_result.h"
#include "bench/run/timing_stage.h"
#include "bench/table/table.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct PublishArguments {
  std::vector<std::string> experiments;
  int jobs = usable_cores();
  bool pages = false;
  bool plan = false;
  bool clocks = false;
  bool scores = false;
  bool fidelity = false;
  bool load = false;
  bool redraw = false;
};

/// Prints what fitting would take, and makes nothing.
void print_plan(const PublishArguments& arguments) {
  PublishPlan plan(project_folder(), Cache::standard().with(Reuse::clean));
  for (const std::string& file : arguments.experiments) {
    SolverRegistry registry;
    plan.add(read_experiment(file, registry, chart_types()));
  }
  std::fputs(terminal_of(plan.table(arguments.jobs)).c_str(), stdout);
}

Publishing publishing_of(const PublishArguments& arguments) {
  if (arguments.fidelity) return Publishing::models;
  return arguments.scores ? Publishing::scores : Publishing::all;
}

ExitCode publish(const PublishArguments& arguments) {
  const std::filesystem::path project = project_folder();
  if (arguments.experiments.empty() && !arguments.pages) {
    throw InputError("name the experiments to publish, or --pages to render the pages alone");
  }
  if (arguments.plan) {
    print_plan(arguments);
    return done;
  }
  if (!arguments.experiments.empty()) require_committed(project);
  const Cache cache = Cache::standard().with(Reuse::clean);
  if (arguments.clocks) {
    const Clocks clocks({arguments.experiments.begin(), arguments.experiments.end()}, project,
                        cache);
    clocks.take(arguments.jobs);
    clocks.write();
    publish_pages(project);
    return done;
  }
  int failures = 0;
  for (const std::string& file : arguments.experiments) {
    SolverRegistry registry;
    const Experiment experiment = read_experiment(file, registry, chart_types());
    if (arguments.redraw) {
      const std::filesystem::path folder = project / "results/published" / experiment.name;
      redraw_published(experiment, folder);
      std::printf("drawn again: %s\n", printable_path(folder.string()).c_str());
      continue;
    }
    if (!arguments.fidelity && !arguments.scores) warn_of_slow_trainings(experiment, cache);
    failures += arguments.load ? publish_load(experiment, registry, project, cache)
                               : publish_experiment(experiment, project, cache, arguments.jobs,
                                                    publishing_of(arguments));
    std::printf("published %s in %s\n", experiment.name.c_str(),
                printable_path((project / "results/published" / experiment.name).string()).c_str());
  }
  publish_pages(project);
  return failures > 0 ? trial_failed : done;
}

}  // namespace

Action add_publish(CLI::App& command) {
  const auto arguments = std::make_shared<PublishArguments>();
  command.add_option("experiments", arguments->experiments, "EXPERIMENT.json ...")
      ->check(CLI::ExistingFile);
  command.add_option("--jobs", arguments->jobs, "As of run")->check(CLI::Range(1, 256));
  command.add_flag("--pages", arguments->pages, "Render the pages alone, of the results there are")
      ->excludes(command.get_option("experiments"));
  command.add_flag("--plan", arguments->plan,
                   "Print what fits and limits will take, as earlier ones took; make nothing");
  CLI::Option* const clocks = command.add_flag(
      "--clocks", arguments->clocks,
      "Take the times of what is published again, those of all experiments together");
  clocks->needs(command.get_option("experiments"));
  CLI::Option* const scores = command
                                  .add_flag("--scores", arguments->scores,
                                            "Make all but the times, which stay as they were "
                                            "published; the inverse of --clocks")
                                  ->excludes(clocks);
  CLI::Option* const fidelity =
      command
          .add_flag("--fidelity", arguments->fidelity,
                    "What `fidelity` makes of the experiments, in place of what `run` does")
          ->excludes(clocks)
          ->excludes(scores);
  CLI::Option* const load =
      command
          .add_flag("--load", arguments->load,
                    "What `timing load` makes of them, with its usual deadlines; refused where the "
                    "machine was busy")
          ->excludes(clocks)
          ->excludes(scores)
          ->excludes(fidelity);
  command
      .add_flag("--redraw", arguments->redraw,
                "Write tables, charts and page of what is published again, with the numbers that "
                "it has; nothing runs")
      ->needs(command.get_option("experiments"))
      ->excludes(clocks)
      ->excludes(scores)
      ->excludes(fidelity)
      ->excludes(load);
  command.footer(
      "Example:\n  ertbench publish experiments/quick.json experiments/table_c1.json\n"
      "Refuses a tree with changes that are not committed, and a program that was built of other\n"
      "sources. Runs what is missing; results of builds with changes are made again. Pages are\n"
      "*.md.in: their numbers are references into results/published (bench/pages/page.h).\n"
      "--clocks leaves all numbers but times as they were published, perhaps on another machine;\n"
      "networks are trained for the clock alone, as what a frame costs does not depend on "
      "weights.\n"
      "--scores makes all other numbers: records of other machines, put into "
      "results/NAME/records,\n"
      "are taken as they are where they are of this code, and nothing is fitted for the clock.");
  return [arguments] { return publish(*arguments); };
}

}  // namespace ertbench
