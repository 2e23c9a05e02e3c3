#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/cli/command.h"
#include "bench/cluster/slurm.h"
#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "bench/fidelity/fidelity.h"
#include "bench/record/cache.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct ElementArguments {
  std::string experiment;
  std::vector<std::string> set;
  std::string list;
  std::size_t element = 0;
  std::string cache;
  std::string reuse = name_of(Reuse::same_code);
  ElementOptions options;
};

ElementOptions options_from(const ElementArguments& arguments) {
  ElementOptions options = arguments.options;
  try {
    const nlohmann::json list = read_json_file(arguments.list);
    options.part = list.at("part").get<std::string>();
    options.units = list.at("elements").at(arguments.element).get<Units>();
    options.only = list.at("only").get<std::vector<std::string>>();
    options.command = list.at("command").get<std::string>();
  } catch (const nlohmann::json::exception& error) {
    throw InputError(arguments.list + ": is no list of elements that has number " +
                     std::to_string(arguments.element) + ": " + printable(error.what()));
  }
  return options;
}

ExitCode element(const ElementArguments& arguments) {
  SolverRegistry registry;
  const ElementOptions options = options_from(arguments);
  const bool report = options.part == "report";
  const Experiment experiment =
      read_experiment(arguments.experiment, registry, report ? chart_types() : ChartTypes(),
                      report ? SolverCheck::all : SolverCheck::none, arguments.set);
  const Cache cache = Cache(arguments.cache).with(reuse_from_name(arguments.reuse));
  return run_element(experiment, cache, options) > 0 ? trial_failed : done;
}

}  // namespace

static Action add_element(CLI::App& command) {
  const auto arguments = std::make_shared<ElementArguments>();
  // Hidden: one element of an array of run --engine slurm.
  add_experiment(command, arguments->experiment);
  command.add_option("--set", arguments->set)->allow_extra_args(false);
  command.add_option("--list", arguments->list)->required();
  command.add_option("--element", arguments->element)->required();
  command.add_option("--out", arguments->options.out)->required();
  command.add_option("--cache", arguments->cache)->required();
  command.add_option("--reuse", arguments->reuse);
  command.add_option("--threads", arguments->options.threads);
  return [arguments] { return element(*arguments); };
}

}  // namespace ertbench

extern "C" void ertbench_part_tools(ertbench::Part& part) {
  using namespace ertbench;
  static constexpr Command commands[] = {{"check", add_check},   {"publish", add_publish},
                                         {"timing", add_timing}, {"fidelity", add_fidelity},
                                         {"export", add_export}, {"element", add_element}};
  part.commands = commands;
  part.stages = [](int scenes) {
    Stages stages;
    stages.push_back(fidelity_stage(scenes));
    return stages;
  };
  part.run_on_slurm = run_on_slurm;
}
