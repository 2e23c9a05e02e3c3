#include <CLI/CLI.hpp>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/run/stages.h"
#include "bench/run/trial.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

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
