// ertbench: reconstruction methods of tomographic tactile skins, compared.
//
//   ertbench run experiments/quick.json
//   ertbench generate experiments/table_c1.json --dataset test --out test.h5
//   ertbench reconstruct --solver solver.json --input frames.h5 --output images.h5
//   ertbench check experiments/quick.json
//   ertbench list
//   ertbench timing 'reconstruct/tsvd'

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>
#include <thread>

#include "bench/charts/chart_types.h"
#include "bench/check/baseline.h"
#include "bench/check/check_command.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/records.h"
#include "bench/record/version.h"
#include "bench/report/fidelity_report.h"
#include "bench/report/results.h"
#include "bench/run/datasets.h"
#include "bench/run/fidelity.h"
#include "bench/run/ladder_run.h"
#include "bench/run/reconstruct.h"
#include "bench/run/runner.h"
#include "bench/run/trial.h"
#include "bench/score/metric_table.h"
#include "bench/timing/timing.h"
#include "core/errors.h"
#include "core/progress.h"
#include "forward/data/generate.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

enum ExitCode { done = 0, regression = 1, trial_failed = 1, bad_input = 2, our_defect = 3 };

struct Arguments {
  std::string experiment;
  std::string out;
  std::vector<std::string> only;
  int jobs = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  bool fresh = false;
  std::string dataset;
  std::string solver;
  std::string input;
  std::string output;
  std::string plugin;
  std::string label;
  std::string stage;
  std::string filter;
  std::optional<int> seed;
  int round = 0;
  int rounds = 3;
  int scenes = 500;
  int threads = 1;
  std::string cache;
  std::string baseline;
  bool update = false;
  bool reuse = false;
  bool warn_times = false;
  bool all = false;
  std::optional<int> seed_count;
};

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

int run(const Arguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  RunOptions options;
  options.out =
      arguments.out.empty() ? fs::path("results") / experiment.name : fs::path(arguments.out);
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
      throw InputError("--only: no solver is labelled \"" + label + "\" in " +
                       arguments.experiment + "; there are " + list_of(labels));
    }
  }
  const Cache cache = Cache::standard();
  const ExperimentResults results = run_experiment(experiment, cache, options);
  report_results(experiment, cache, results, options.out);
  return results.failures > 0 ? trial_failed : done;
}

int check(const Arguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  CheckOptions options;
  options.out = arguments.out;
  options.baseline = arguments.baseline;
  options.jobs = arguments.jobs;
  options.all = arguments.all;
  options.update = arguments.update;
  options.seeds = arguments.seed_count;
  options.reuse = arguments.reuse;
  options.warn_times = arguments.warn_times;
  return check_experiment(experiment, registry, options) ? done : regression;
}

int generate(const Arguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  const Cache cache = Cache::standard();
  if (arguments.dataset.empty() && arguments.out.empty()) {
    ensure_datasets(experiment, cache);
    for (const DatasetSpec* spec : experiment.datasets()) {
      std::printf("%s: %s\n", spec->name.c_str(), cache.dataset(*spec).c_str());
    }
    return done;
  }
  std::vector<std::string> names;
  for (const DatasetSpec* spec : experiment.datasets()) names.push_back(spec->name);
  std::string name = arguments.dataset;
  if (name.empty() && names.size() == 1) name = names.front();
  const DatasetSpec* spec = experiment.find_dataset(name);
  if (!spec) {
    throw InputError("--dataset: must name one of the datasets of " + arguments.experiment + ": " +
                     list_of(names) + (name.empty() ? "" : "; got \"" + name + "\""));
  }
  const fs::path file = arguments.out.empty() ? cache.dataset(*spec) : fs::path(arguments.out);
  if (arguments.out.empty()) fs::create_directories(file.parent_path());
  Progress progress("generating \"" + name + "\"");
  const int threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  generate_dataset(*spec, file, {threads, [&](std::uint64_t written, std::uint64_t total) {
                                   progress.update(written, total);
                                 }});
  std::printf("%s: %llu scenes in %s\n", name.c_str(), static_cast<unsigned long long>(spec->count),
              file.c_str());
  return done;
}

int reconstruct(const Arguments& arguments) {
  SolverRegistry registry;
  if (!arguments.plugin.empty()) registry.load_plugin(arguments.plugin);
  const ReconstructSummary summary =
      reconstruct_file(arguments.solver, arguments.input, arguments.output, registry);
  std::printf("%llu frames in %s, %llu not converged, %llu undefined, %llu suspect\n",
              static_cast<unsigned long long>(summary.frames), arguments.output.c_str(),
              static_cast<unsigned long long>(summary.not_converged),
              static_cast<unsigned long long>(summary.undefined),
              static_cast<unsigned long long>(summary.suspect));
  const std::pair<const char*, std::uint64_t> reasons[] = {
      {"a dead electrode", summary.dead_electrode},
      {"more noise than the solver was fitted for", summary.noise},
      {"voltages out of the range that it was fitted for", summary.out_of_range}};
  for (const auto& [reason, frames] : reasons) {
    if (frames > 0)
      std::printf("  %llu with %s\n", static_cast<unsigned long long>(frames), reason);
  }
  return done;
}

int list() {
  SolverRegistry registry;
  std::printf("Solvers (\"type\" in an experiment's \"solvers\" list):\n");
  for (const std::string& type : registry.types()) {
    const SolverInfo* info = registry.find(type);
    if (!info) {
      std::printf("\n  %s\n      not available: its plugin is not built\n", type.c_str());
      continue;
    }
    std::printf("\n  %s\n      %s\n", type.c_str(), info->summary.c_str());
    for (const ParameterInfo& parameter : info->parameters) {
      std::printf("      \"%s\": %s\n", parameter.name.c_str(), parameter.description.c_str());
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
    const Experiment experiment = read_experiment(file, registry, chart_types());
    std::printf("\n  experiments/%s\n      %s\n", file.filename().c_str(),
                experiment.question.c_str());
  }
  return done;
}

int timing(const Arguments& arguments) {
  TimingOptions options;
  options.filter = arguments.filter;
  options.rounds = arguments.rounds;
  if (!arguments.out.empty()) options.out = arguments.out;
  return run_timing(options) > 0 ? trial_failed : done;
}

int fidelity(const Arguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment =
      read_experiment(arguments.experiment, registry, chart_types(), SolverCheck::none);
  const fs::path out =
      arguments.out.empty() ? fs::path("results") / experiment.name : fs::path(arguments.out);
  report_fidelity(experiment, measure_fidelity(experiment, arguments.scenes), out);
  return done;
}

int trial(const Arguments& arguments) {
  SolverRegistry registry;
  // The run has checked all solvers; here the plugins of the others would be in the way.
  const Experiment experiment =
      read_experiment(arguments.experiment, registry, {}, SolverCheck::none);
  const Cache cache = arguments.cache.empty() ? Cache::standard() : Cache(arguments.cache);
  for (const SolverEntry& entry : experiment.solvers) {
    if (entry.label != arguments.label || entry.seed != arguments.seed) continue;
    if (arguments.stage == name_of(Stage::timing)) {
      run_timing_round(experiment, entry, cache, registry, arguments.round, arguments.out);
    } else if (arguments.stage == name_of(Stage::ladders)) {
      run_ladder_stage(experiment, entry, cache, registry, arguments.threads, arguments.out);
    } else {
      run_accuracy_stage(experiment, entry, cache, registry, arguments.threads, arguments.out);
    }
    return done;
  }
  throw InputError("no solver is labelled \"" + arguments.label + "\"");
}

int parse_and_run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"Compares reconstruction methods for tomographic tactile skins.", "ertbench"};
  app.require_subcommand(1);
  app.set_version_flag("--version", build_commit());
  app.footer(
      "`ertbench COMMAND --help` shows an example of each command.\n"
      "Exit codes: 0 done; 1 a trial failed, or a check found something worse; 2 input that\n"
      "cannot be used; 3 a defect of ertbench.");

  CLI::App* run_command =
      app.add_subcommand("run", "Run an experiment: data, solvers, tables, figures");
  run_command->add_option("EXPERIMENT.json", arguments.experiment)->required();
  run_command->add_option("--out", arguments.out, "Result folder (default: results/EXPERIMENT)");
  run_command
      ->add_option("--only", arguments.only,
                   "Run only the solvers of these labels (all their seeds; the\n"
                   "label of a sweep stands for all of it)")
      ->delimiter(',');
  run_command
      ->add_option("--jobs", arguments.jobs,
                   "Trials fitted and scored at a time, the cores shared out among them\n"
                   "(default: one for each core; timings always run alone)")
      ->check(CLI::Range(1, 256));
  run_command->add_flag("--fresh", arguments.fresh,
                        "Fit and measure again what is finished already");
  run_command->footer(
      "Example:\n  ertbench run experiments/table_c1.json --only tsvd,pdipm --jobs 2\n"
      "Solvers with \"seeds\" are trained once for each; charts of their training are in\n"
      "RESULTS/training/. The file's \"charts\" are drawn beside the table. With \"ladders\" each\n"
      "solver is taken to where it breaks down: RESULTS/breakdown.md, breakdown.csv and charts.");

  CLI::App* check_command =
      app.add_subcommand("check", "Run an experiment and compare with its baseline");
  check_command->add_option("EXPERIMENT.json", arguments.experiment)->required();
  check_command->add_flag("--update", arguments.update,
                          "Write the baseline anew, and say what changed");
  check_command
      ->add_option("--seeds", arguments.seed_count,
                   "With --update: training seeds behind the interval of a learned solver\n"
                   "(default: those of the experiment if 5 or more, else 8)")
      ->check(CLI::Range(least_seeds, 100));
  check_command->add_flag("--all", arguments.all, "Show every quantity, not just what changed");
  check_command->add_flag("--warn-times", arguments.warn_times,
                          "Only warn about times, as on another cpu: for shared machines");
  check_command->add_flag(
      "--reuse", arguments.reuse,
      "Take what `run` left in the cache and in results/EXPERIMENT: quick, but\n"
      "blind to changes of the program since");
  check_command->add_option("--baseline", arguments.baseline,
                            "Baseline (default: results/baselines/EXPERIMENT.json)");
  check_command->add_option("--out", arguments.out,
                            "Result folder (default: results/EXPERIMENT/check)");
  check_command
      ->add_option("--jobs", arguments.jobs, "Trials fitted and scored at a time, as in `run`")
      ->check(CLI::Range(1, 256));
  check_command->footer(
      "Example:\n  ertbench check experiments/quick.json\n"
      "Everything is made anew by this very program, in a cache of its own; a check that was cut\n"
      "off goes on where it stopped. Exit code 1 where something is worse, slower or missing.\n"
      "Times are multiples of a calibration loop, and only warned about on another cpu.");

  CLI::App* generate_command =
      app.add_subcommand("generate", "Write the datasets of an experiment");
  generate_command->add_option("EXPERIMENT.json", arguments.experiment)->required();
  generate_command->add_option("--dataset", arguments.dataset,
                               "Only this one (default: all, into the cache)");
  generate_command->add_option("--out", arguments.out,
                               "HDF5 file to write (default: in the cache)");
  generate_command->footer(
      "Example:\n  ertbench generate experiments/table_c1.json --dataset test --out test.h5\n"
      "A run that was cut off goes on where it stopped when the same command is given again.");

  CLI::App* reconstruct_command = app.add_subcommand("reconstruct", "Images from a file of frames");
  reconstruct_command
      ->add_option("--solver", arguments.solver, "One entry of a \"solvers\" list, JSON")
      ->required();
  reconstruct_command
      ->add_option("--input", arguments.input,
                   "HDF5 with /voltages [N, 208] V and /reference_voltages [208] V")
      ->required();
  reconstruct_command
      ->add_option("--output", arguments.output,
                   "HDF5 with /conductivity_change [N, 24, 24] S/m and /status [N]")
      ->required();
  reconstruct_command->add_option("--plugin", arguments.plugin,
                                  "Shared library of your own solvers");
  reconstruct_command->footer(
      "Example:\n  echo '{\"type\": \"one-step-gn\", \"prior\": \"noser\", \"lambda\": 0.1}' > "
      "gn.json\n"
      "  ertbench reconstruct --solver gn.json --input test.h5 --output images.h5");

  CLI::App* list_command =
      app.add_subcommand("list", "Solvers with their parameters; metrics; experiments");
  list_command->footer("Example:\n  ertbench list");

  CLI::App* timing_command =
      app.add_subcommand("timing", "Run the timing benchmarks, beside the limits of this machine");
  timing_command->add_option("FILTER", arguments.filter,
                             "Regular expression of names; default: all, several minutes");
  timing_command->add_option("--out", arguments.out,
                             "JSON file to write (default: results/timing.json)");
  timing_command
      ->add_option("--rounds", arguments.rounds,
                   "Rounds of all benchmark programs, of which the median counts (default: 3)")
      ->check(CLI::Range(1, 99));
  timing_command->footer(
      "Example:\n  ertbench timing 'reconstruct/(tsvd|fcnn)' --out timing.json\n"
      "The machine should be otherwise idle. \"0.80 of stream\" means that the least time this\n"
      "machine allows, here for reading the matrices once, is 0.80 of what was measured.");

  CLI::App* fidelity_command = app.add_subcommand(
      "fidelity", "Error and time of the forward models on an experiment's scenes");
  fidelity_command->add_option("EXPERIMENT.json", arguments.experiment)->required();
  fidelity_command->add_option("--out", arguments.out,
                               "Result folder (default: results/EXPERIMENT)");
  fidelity_command
      ->add_option("--scenes", arguments.scenes, "Scenes of each dataset (default: 500)")
      ->check(CLI::Range(10, 1000000));
  fidelity_command->footer(
      "Example:\n  ertbench fidelity experiments/fidelity.json --scenes 200\n"
      "\"grid\": \"auto\" against the grids of 24, 48, 96 and 192, one thread: how long a scene\n"
      "takes, how far its voltages are from the converged ones, and how often the estimate of\n"
      "\"auto\" promised too much.");

  CLI::App* trial_command = app.add_subcommand("trial", "One stage of one solver; used by run");
  trial_command->group("");  // hidden
  trial_command->add_option("EXPERIMENT.json", arguments.experiment)->required();
  trial_command->add_option("--label", arguments.label)->required();
  trial_command->add_option("--stage", arguments.stage)->required();
  trial_command->add_option("--seed", arguments.seed);
  trial_command->add_option("--round", arguments.round);
  trial_command->add_option("--out", arguments.out)->required();
  trial_command->add_option("--threads", arguments.threads);
  trial_command->add_option("--cache", arguments.cache);

  const std::string command = argc > 1 ? argv[1] : "";
  const auto commands = app.get_subcommands(nullptr);
  const bool known = std::any_of(commands.begin(), commands.end(),
                                 [&](const CLI::App* one) { return one->get_name() == command; });
  if (!command.empty() && command[0] != '-' && !known) {
    throw InputError("no command is called \"" + command +
                     "\"; there are run, check, generate, reconstruct, list, timing, fidelity");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? done : bad_input;
  }
  if (*run_command) return run(arguments);
  if (*check_command) return check(arguments);
  if (*generate_command) return generate(arguments);
  if (*reconstruct_command) return reconstruct(arguments);
  if (*list_command) return list();
  if (*timing_command) return timing(arguments);
  if (*fidelity_command) return fidelity(arguments);
  return trial(arguments);
}

}  // namespace
}  // namespace ertbench

#ifdef __SANITIZE_ADDRESS__
// libhdf5 loses a few hundred bytes when it refuses some damaged files.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
#endif

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("ertbench"));
  spdlog::set_pattern("%^%l%$: %v");
  try {
    return ertbench::parse_and_run(argc, argv);
  } catch (const ertbench::InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return ertbench::bad_input;
  } catch (const std::filesystem::filesystem_error& e) {
    std::fprintf(stderr, "%s: %s; check that the folder exists and can be written\n",
                 e.path1().c_str(), e.code().message().c_str());
    return ertbench::bad_input;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "ertbench failed; please report this: %s\n", e.what());
    return ertbench::our_defect;
  }
}
