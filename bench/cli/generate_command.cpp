#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/charts/chart_types.h"
#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/run/datasets.h"
#include "bench/run/machine_load.h"
#include "core/errors.h"
#include "core/progress.h"
#include "core/text.h"
#include "forward/data/generate.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct GenerateArguments {
  std::string experiment;
  std::string dataset;
  std::string out;
};

ExitCode generate(const GenerateArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  const Cache cache = Cache::standard();
  if (arguments.dataset.empty() && arguments.out.empty()) {
    ensure_datasets(experiment, cache);
    for (const DatasetSpec* spec : experiment.datasets()) {
      std::printf("%s: %s\n", spec->name.c_str(),
                  printable_path(cache.dataset(*spec).string()).c_str());
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
                     list_of(names) + (name.empty() ? "" : "; got \"" + printable(name) + "\""));
  }
  const std::filesystem::path file =
      arguments.out.empty() ? cache.dataset(*spec) : std::filesystem::path(arguments.out);
  if (arguments.out.empty()) {
    std::filesystem::create_directories(file.parent_path());
  } else {
    std::vector<std::filesystem::path> inputs = experiment.plugins;
    inputs.insert(inputs.end(), experiment.files.begin(), experiment.files.end());
    require_dataset_output(file, inputs);
  }
  Progress progress("generating \"" + name + "\"");
  generate_dataset(*spec, file, {usable_cores(), [&](std::uint64_t written, std::uint64_t total) {
                                   progress.update(written, total);
                                 }});
  std::printf("%s: %llu scenes in %s\n", name.c_str(), static_cast<unsigned long long>(spec->count),
              printable_path(file.string()).c_str());
  warn_of_missed_promise(*spec, file);
  return done;
}

}  // namespace

Action add_generate(CLI::App& command) {
  const auto arguments = std::make_shared<GenerateArguments>();
  command.description("Write the datasets of an experiment");
  add_experiment(command, arguments->experiment);
  command.add_option("--dataset", arguments->dataset,
                     "Only this one (default: all, into the cache)");
  command.add_option("--out", arguments->out,
                     "HDF5 file to write (default: in the cache); of what is there,\n"
                     "only a dataset is written over");
  command.footer(
      "Example:\n  ertbench generate experiments/table_c1.json --dataset test --out test.h5\n"
      "A run that was cut off goes on where it stopped when the same command is given again.");
  return [arguments] { return generate(*arguments); };
}

}  // namespace ertbench
