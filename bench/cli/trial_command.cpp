#include <CLI/CLI.hpp>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/records.h"
#include "bench/run/ladder_run.h"
#include "bench/run/trial.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct TrialArguments {
  std::string experiment;
  std::string label;
  std::string stage;
  std::optional<int> seed;
  int round = 0;
  std::string out;
  int threads = 1;
  std::string cache;
};

ExitCode trial(const TrialArguments& arguments) {
  SolverRegistry registry;
  // The run has checked all solvers; here the plugins of the others would be in the way.
  const Experiment experiment = read_experiment(arguments.experiment, registry, SolverCheck::none);
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

}  // namespace

Action add_trial(CLI::App& command) {
  const auto arguments = std::make_shared<TrialArguments>();
  command.description("One stage of one solver; used by run");
  command.group("");  // hidden
  add_experiment(command, arguments->experiment);
  command.add_option("--label", arguments->label)->required();
  command.add_option("--stage", arguments->stage)->required();
  command.add_option("--seed", arguments->seed);
  command.add_option("--round", arguments->round);
  command.add_option("--out", arguments->out)->required();
  command.add_option("--threads", arguments->threads);
  command.add_option("--cache", arguments->cache);
  return [arguments] { return trial(*arguments); };
}

}  // namespace ertbench
