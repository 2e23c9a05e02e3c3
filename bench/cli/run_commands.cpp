#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/cli/command.h"
#include "bench/cluster/slurm.h"
#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/record/cache.h"
#include "bench/run/job_runner.h"
#include "bench/run/results.h"
#include "bench/run/runner.h"
#include "bench/run/timing_stage.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

struct RunArguments {
  std::string experiment;
  std::string out;
  SlurmOptions options;
  std::vector<std::string> set;
  std::string precision;
  bool jobs_given = false;
  bool rebuild_stale = false;
  std::string engine = "local";
};

/// A word of a command line as a shell takes it.
std::string shell_word(const std::string& text) {
  const bool plain = !text.empty() && std::ranges::all_of(text, [](unsigned char c) {
    return std::isalnum(c) ||
           std::string_view("_-+=.,:/%@").find(static_cast<char>(c)) != std::string_view::npos;
  });
  return plain ? text : shell_quoted(text);
}

/// All that the results depend on; not what only says which of them are made anew, or where.
std::string command_again(const RunArguments& arguments) {
  std::string out = "./ertbench run " + shell_word(printable_path(arguments.experiment));
  for (const std::string& one : arguments.set) out += " --set " + shell_word(printable(one, 1000));
  if (!arguments.precision.empty()) out += " --precision " + arguments.precision;
  for (const std::string& one : arguments.options.only) {
    out += " --only " + shell_word(printable(one));
  }
  if (arguments.jobs_given) out += " --jobs " + std::to_string(arguments.options.jobs);
  if (arguments.engine == "slurm") {
    out += " --engine slurm";
    const auto option = [&](const char* name, const std::string& value) {
      if (!value.empty()) out += std::string(" --") + name + " " + shell_word(printable(value));
    };
    const SlurmOptions& slurm = arguments.options;
    option("partition", slurm.partition);
    option("time", slurm.time);
    option("account", slurm.account);
    if (slurm.threads != 1) option("threads", std::to_string(slurm.threads));
  }
  if (!arguments.out.empty()) out += " --out " + shell_word(printable_path(arguments.out));
  return out;
}

/// Throws InputError for a label of --only that no row and no sweep has.
void require_labels(const RunArguments& arguments, const Experiment& experiment) {
  const std::vector<std::string> labels = distinct(experiment.solvers, &SolverEntry::label);
  for (const std::string& label : arguments.options.only) {
    const bool known = std::ranges::any_of(
        experiment.solvers, [&](const SolverEntry& entry) { return entry.is_named(label); });
    if (known) continue;
    const std::string near = nearest_word(label, labels);
    throw InputError(
        "--only: no solver is labelled \"" + printable(label) + "\" in " + arguments.experiment +
        (near.empty() ? "" : "; did you mean \"" + near + "\"?") + "; there are " + joined(labels));
  }
}

ExitCode run_by_slurm(const RunArguments& arguments, const Experiment& experiment,
                      const Cache& cache) {
  if (arguments.options.fresh) {
    throw InputError("--fresh: not with --engine slurm; remove the result folder, or name another");
  }
  SlurmOptions options = arguments.options;
  options.out = result_folder(arguments.out, experiment.name);
  options.command = command_again(arguments);
  const SlurmOutcome outcome = part_named("tools").run_on_slurm(experiment, cache, options);
  return outcome.reported && outcome.failures == 0 ? done : trial_failed;
}

Experiment wanted_experiment(const RunArguments& arguments, SolverRegistry& registry) {
  const auto read = [&](const std::vector<std::string>& overrides) {
    return read_experiment(arguments.experiment, registry, chart_types(), SolverCheck::all,
                           overrides);
  };
  Experiment experiment = read(arguments.set);
  if (arguments.precision.empty()) return experiment;
  std::vector<std::string> overrides = arguments.set;
  for (std::string& one : precision_overrides(experiment, arguments.precision)) {
    overrides.push_back(std::move(one));
  }
  return read(overrides);
}

ExitCode run(const RunArguments& arguments) {
  if (const auto json = read_experiment_json(arguments.experiment, arguments.set);
      json.content->contains("data")) {
    const fs::path folder =
        result_folder(arguments.out, printable(fs::path(arguments.experiment).stem().string()));
    return part_named("ktc2023").run_ktc2023(json, folder, command_again(arguments)) > 0
               ? trial_failed
               : done;
  }
  SolverRegistry registry;
  const Experiment experiment = wanted_experiment(arguments, registry);
  require_labels(arguments, experiment);
  const Cache cache =
      Cache::standard().with(arguments.rebuild_stale ? Reuse::same_program : Reuse::same_code);
  if (arguments.engine == "slurm") return run_by_slurm(arguments, experiment, cache);
  warn_of_slow_trainings(experiment, cache, arguments.options.only);
  RunOptions options = arguments.options;
  options.out = result_folder(arguments.out, experiment.name);
  options.command = command_again(arguments);
  const ExperimentResults results = run_experiment(experiment, cache, options);
  const std::size_t undrawn = report_experiment(experiment, cache, results, options.out);
  return results.failures > 0 || undrawn > 0 ? trial_failed : done;
}

void add_slurm_options(CLI::App& command, RunArguments& arguments) {
  CLI::Option* engine =
      command
          .add_option("--engine", arguments.engine,
                      "local: processes of this machine (default); slurm: jobs of a cluster\n"
                      "whose nodes share the result folder and the cache")
          ->check(CLI::IsMember({"local", "slurm"}));
  SlurmOptions& slurm = arguments.options;
  command.add_option("--partition", slurm.partition, "Of sbatch")->needs(engine);
  command.add_option("--time", slurm.time, "Of sbatch, for each element")->needs(engine);
  command.add_option("--account", slurm.account, "Of sbatch")->needs(engine);
  command.add_option("--array-limit", slurm.array_limit, "Elements of an array that run at a time")
      ->check(CLI::Range(1, 1000000))
      ->needs(engine);
  command.add_option("--threads", slurm.threads, "Of an element, and cores that it asks for")
      ->check(CLI::Range(1, 1024))
      ->needs(engine);
  command.add_flag("--dry-run", slurm.dry_run, "Print the scripts and commands, submit nothing")
      ->needs(engine);
}

struct TrialArguments {
  std::string experiment;
  std::vector<std::string> set;
  std::string stage;
  std::string job;
  int scenes = fidelity_usual_scenes;
  std::string out;
  int threads = 1;
  std::string cache;
  std::string reuse = name_of(Reuse::same_code);
};

ExitCode trial(const TrialArguments& arguments) {
  SolverRegistry registry;
  // The run has checked all solvers; here the plugins of the others would be in the way.
  Experiment experiment =
      read_experiment(arguments.experiment, registry, {}, SolverCheck::none, arguments.set);
  const Cache cache = (arguments.cache.empty() ? Cache::standard() : Cache(arguments.cache))
                          .with(reuse_from_name(arguments.reuse));
  run_trial(*stage_named(arguments.stage, arguments.scenes), arguments.job, experiment, cache,
            registry, arguments.threads, arguments.out);
  return done;
}

}  // namespace

Action add_run(CLI::App& command) {
  const auto arguments = std::make_shared<RunArguments>();
  arguments->options.jobs = usable_cores();
  command.description("Run an experiment: data, solvers, tables, figures");
  add_experiment(command, arguments->experiment);
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT)");
  command
      .add_option("--only", arguments->options.only,
                  "Run only the solvers of these labels (all their seeds; the\n"
                  "label of a sweep stands for all of it)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      .add_option("--set", arguments->set,
                  "A value in place of the file's: PATH=VALUE, the path with dots,\n"
                  "lists by number from 0; the value JSON, else text. May stand again")
      ->allow_extra_args(false);
  CLI::Option* jobs =
      command
          .add_option("--jobs", arguments->options.jobs,
                      "Trials fitted and scored at a time, the cores shared out among them\n"
                      "(default: one for each core; timings always run alone)")
          ->check(CLI::Range(1, 256));
  command
      .add_option("--precision", arguments->precision,
                  "float32: train in it what the file trains in bfloat16, where the\n"
                  "processor has no AVX512-BF16; other networks than the file's")
      ->check(CLI::IsMember({"float32"}));
  add_device(command);
  command.add_flag("--fresh", arguments->options.fresh,
                   "Fit and measure again what is finished already");
  command.add_flag("--rebuild-stale", arguments->rebuild_stale,
                   "Make again what another build of the program made, even where nothing\n"
                   "that it depends on has changed since; what depends on it always is");
  add_slurm_options(command, *arguments);
  command.footer(
      "Examples:\n  ertbench run experiments/table_c1.json --only tsvd,pdipm --jobs 2\n"
      "  ertbench run experiments/quick.json --set datasets.test.count=400 --out results/400\n"
      "  ertbench run experiments/grid_alpha_beta.json --engine slurm --time 2:00:00\n"
      "Solvers with \"seeds\" are trained once for each; charts of their training are in\n"
      "RESULTS/training/. The file's \"charts\" are drawn beside the table. With \"ladders\" each\n"
      "solver is taken to where it fails: RESULTS/breakdown.md, breakdown.csv and charts.");
  return [arguments, jobs] {
    arguments->jobs_given = jobs->count() > 0;
    return run(*arguments);
  };
}

Action add_report(CLI::App& command) {
  const auto results = std::make_shared<std::string>();
  const auto out = std::make_shared<std::string>();
  command.description("Make the page, the tables and the charts of a result from its summary.json");
  command.add_option("RESULTS", *results, "Folder with a summary.json")->required();
  command.add_option("--out", *out, "New or empty folder")->required();
  command.footer(
      "Example:\n  ertbench report results/published/table_c1 --out report\n"
      "Writes report.html, table.md, table.csv, table.tex and the charts as SVG and PNG. It needs "
      "no\n"
      "dataset and fits nothing; what a summary does not hold, such as example images, is named.");
  return [results, out] {
    const SummaryReport report = report_summary(*results, *out, chart_types());
    std::printf("Report in %s\n", printable_path(*out).c_str());
    if (!report.elsewhere.empty()) {
      std::printf("Not in summary.json and so left out: %s; `%s` makes them\n",
                  joined(report.elsewhere).c_str(), printable(report.command, 1000).c_str());
    }
    return report.undrawn > 0 ? trial_failed : done;
  };
}

Action add_trial(CLI::App& command) {
  const auto arguments = std::make_shared<TrialArguments>();
  command.description("One job of one stage; used by run and fidelity");
  command.group("");  // hidden
  add_experiment(command, arguments->experiment);
  command.add_option("--set", arguments->set)->allow_extra_args(false);
  command.add_option("--stage", arguments->stage)->required();
  command.add_option("--job", arguments->job)->required();
  command.add_option("--scenes", arguments->scenes);
  command.add_option("--out", arguments->out)->required();
  command.add_option("--threads", arguments->threads);
  command.add_option("--cache", arguments->cache);
  command.add_option("--reuse", arguments->reuse);
  return [arguments] { return trial(*arguments); };
}

}  // namespace ertbench
