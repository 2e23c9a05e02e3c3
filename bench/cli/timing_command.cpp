#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/load/load_report.h"
#include "bench/load/load_run.h"
#include "bench/record/cache.h"
#include "bench/table/writers.h"
#include "bench/timing/timing.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct TimingArguments {
  std::string filter;
  std::string out;
  int rounds = 3;
};

ExitCode timing(const TimingArguments& arguments) {
  TimingOptions options;
  options.filter = arguments.filter;
  options.rounds = arguments.rounds;
  if (!arguments.out.empty()) options.out = arguments.out;
  return run_timing(options) > 0 ? trial_failed : done;
}

struct LoadArguments {
  std::string experiment;
  std::string out;
  std::vector<double> deadlines_ms;
  LoadOptions options;
};

ExitCode load(const LoadArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment =
      read_experiment(arguments.experiment, registry, {}, SolverCheck::none);
  LoadOptions options = arguments.options;
  if (!arguments.deadlines_ms.empty()) options.deadlines_s.clear();
  for (const double ms : arguments.deadlines_ms) options.deadlines_s.push_back(ms / 1000);
  std::sort(options.deadlines_s.begin(), options.deadlines_s.end());
  const std::filesystem::path folder = result_folder(arguments.out, experiment.name);
  bool drawn = true;
  options.finished = [&](const LoadResults& so_far) { drawn = write_load(so_far, folder); };
  const LoadResults results = run_load(experiment, Cache::standard(), registry, options);
  std::printf("%s%s\n", terminal_of(load_table(results)).c_str(),
              printable_path((folder / "load.md").string()).c_str());
  const bool failed = std::any_of(results.solvers.begin(), results.solvers.end(),
                                  [](const SolverLoad& one) { return !one.failure.empty(); });
  return failed || !drawn ? trial_failed : done;
}

/// Returns what runs it, and the subcommand.
std::pair<CLI::App*, Action> add_load(CLI::App& timing_command) {
  const auto arguments = std::make_shared<LoadArguments>();
  CLI::App& command = *timing_command.add_subcommand(
      "load", "The highest rate of frames at which each solver keeps a deadline");
  add_experiment(command, arguments->experiment);
  command
      .add_option("--deadline", arguments->deadlines_ms,
                  "Deadlines of 99 % of the frames, ms, up to 1000 (default: 1,5,20)")
      ->delimiter(',')
      ->check(CLI::Range(1e-3, 1e3));
  command.add_option("--only", arguments->options.only, "Only these solvers, labels")
      ->delimiter(',');
  command
      .add_option("--frames", arguments->options.frames,
                  "Of each run at a rate, at least (default: 1000)")
      ->check(CLI::Range(662, 10000000));
  command.add_option("--seed", arguments->options.seed, "Of Poisson arrivals (default: 1)");
  command
      .add_option("--threads", arguments->options.threads,
                  "Of fits that are not in the cache (default: 1)")
      ->check(CLI::Range(1, 1024));
  command.add_option("--out", arguments->out, "Result folder (default: results/EXPERIMENT)");
  command.footer(
      "Example:\n  ertbench timing load experiments/quick.json --only one-step-gn,tsvd "
      "--deadline 1,5\n"
      "Frames arrive at a fixed rate and as a Poisson process, whether the solver is ready or "
      "not;\n"
      "latency counts from the arrival. The machine should be otherwise idle; that it was not is\n"
      "noticed and said. See docs/live.md.");
  return {&command, [arguments] { return load(*arguments); }};
}

}  // namespace

Action add_timing(CLI::App& command) {
  const auto arguments = std::make_shared<TimingArguments>();
  command.description("Run the timing benchmarks, beside the limits of this machine");
  command.add_option("FILTER", arguments->filter,
                     "Regular expression of names; default: all, several minutes");
  command.add_option("--out", arguments->out, "JSON file to write (default: results/timing.json)");
  command
      .add_option("--rounds", arguments->rounds,
                  "Rounds of all benchmark programs, of which the median counts (default: 3)")
      ->check(CLI::Range(1, 99));
  command.footer(
      "Example:\n  ertbench timing 'reconstruct/(tsvd|fcnn)' --out timing.json\n"
      "The machine should be otherwise idle. \"0.80 of stream\" means that the least time this\n"
      "machine allows, here for reading the matrices once, is 0.80 of what was measured.");
  const std::pair<CLI::App*, Action> with_load = add_load(command);
  return [arguments, with_load] {
    return with_load.first->parsed() ? with_load.second() : timing(*arguments);
  };
}

}  // namespace ertbench
