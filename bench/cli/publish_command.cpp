#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/publish/publish.h"
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
  bool redraw = false;
  std::vector<std::string> set;
};

/// `name`: a file, or the name of one in experiments/.
std::filesystem::path experiment_file(const std::string& name,
                                      const std::filesystem::path& project) {
  if (name.ends_with(".json")) return name;
  return std::filesystem::proximate(project / "experiments" / (name + ".json"));
}

ExitCode publish(const PublishArguments& arguments) {
  const std::filesystem::path project = project_folder();
  if (arguments.experiments.empty() && !arguments.pages) {
    throw InputError("name the experiments to publish, or --pages to render the pages alone");
  }
  if (!arguments.experiments.empty() && !arguments.redraw) require_committed(project);
  const Cache cache = Cache::standard().with(Reuse::clean);
  int failures = 0;
  for (const std::string& name : arguments.experiments) {
    if (arguments.redraw) {
      redraw_published(name, project);
      continue;
    }
    SolverRegistry registry;
    const Experiment experiment = read_experiment(experiment_file(name, project), registry,
                                                  chart_types(), SolverCheck::all, arguments.set);
    warn_of_slow_trainings(experiment, cache);
    failures += publish_experiment(experiment, project, cache, arguments.jobs);
    std::printf("published %s in %s\n", experiment.name.c_str(),
                printable_path((project / "results/published" / experiment.name).string()).c_str());
  }
  publish_pages(project);
  return failures > 0 ? trial_failed : done;
}

}  // namespace

Action add_publish(CLI::App& command) {
  const auto arguments = std::make_shared<PublishArguments>();
  command.add_option("experiments", arguments->experiments, "EXPERIMENT.json or its name ...");
  command.add_option("--jobs", arguments->jobs, "As of run")->check(CLI::Range(1, 256));
  command.add_option("--set", arguments->set, "As of run, for files that are elsewhere")
      ->allow_extra_args(false);
  add_device(command);
  command
      .add_flag("--pages", arguments->pages, "Render the pages alone, of the results that exist")
      ->excludes(command.get_option("experiments"));
  command.add_flag(
      "--redraw", arguments->redraw,
      "Run nothing: write the tables and charts of the named results again, as far as\n"
      "their summaries hold what they show");
  command.footer(
      "Example:\n  ertbench publish quick table_c1\n"
      "Refuses a tree with changes that are not committed, and a program that was built of other\n"
      "sources. Runs what is missing; results of builds with changes are reproduced. Pages are\n"
      "*.md.in: their numbers are references into results/published (bench/pages/page.h).");
  return [arguments] { return publish(*arguments); };
}

}  // namespace ertbench
