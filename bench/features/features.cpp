#include "bench/features/features.h"

#include <dlfcn.h>

#include <cstdio>
#include <map>
#include <utility>

#include "bench/report/bar_chart.h"
#include "bench/report/heat_map.h"
#include "bench/run/accuracy_stage.h"
#include "bench/run/results.h"
#include "bench/speed/speed_chart.h"
#include "bench/training/training_budget.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// The folder of the library that this function is in.
fs::path own_folder() {
  Dl_info info;
  if (!dladdr(reinterpret_cast<const void*>(&part_named), &info)) return {};
  return fs::absolute(info.dli_fname).parent_path();
}

Part loaded(const std::string& name) {
  const std::string library = "libertbench_" + name + ".so";
  fs::path file = own_folder() / library;
  if (!fs::exists(file)) file = own_folder() / "ertbench" / library;
  if (!fs::exists(file)) throw PartMissing(name);
  void* const handle = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw std::runtime_error(file.string() + ": cannot be loaded: " + dlerror());
  const auto fill =
      reinterpret_cast<void (*)(Part&)>(dlsym(handle, ("ertbench_part_" + name).c_str()));
  if (!fill) throw std::runtime_error(file.string() + ": is no part of this program");
  Part part;
  fill(part);
  return part;
}

template <typename T>
ChartType chart() {
  return {T::type, [](const ChartRequest& request) { return std::make_shared<const T>(request); }};
}

}  // namespace

PartMissing::PartMissing(const std::string& part)
    : std::runtime_error("the part \"" + part +
                         "\" of the program is not built; build the target ertbench_" + part),
      part_(part) {}

const Part& part_named(const std::string& name) {
  static std::map<std::string, Part> parts;
  const auto found = parts.find(name);
  return found != parts.end() ? found->second : parts.emplace(name, loaded(name)).first->second;
}

Stages stages_of_run(const Experiment& experiment, Machines machines) {
  Stages stages;
  stages.push_back(accuracy_stage());
  stages.push_back(timing_stage(machines));
  const auto add_from = [&](const char* part) {
    for (auto& stage : part_named(part).stages(0)) stages.push_back(std::move(stage));
  };
  if (experiment.ladders) add_from("ladders");
  if (experiment.folds || !experiment.studies.empty()) add_from("studies");
  return stages;
}

Stages stages_of_fidelity(int scenes) { return part_named("tools").stages(scenes); }

std::unique_ptr<Stage> stage_named(const std::string& name, int scenes) {
  static constexpr std::pair<const char*, const char*> part_of_stage[] = {{"ladders", "ladders"},
                                                                          {"folds", "studies"},
                                                                          {"hours", "studies"},
                                                                          {"studies", "studies"},
                                                                          {"fidelity", "tools"}};
  Stages stages = stages_of_run(Experiment());
  std::string names;
  for (const auto& stage : stages) names += stage->name() + ", ";
  for (const auto& [stage, part] : part_of_stage) {
    names += std::string(stage) + (stage == std::string("fidelity") ? "" : ", ");
    if (name == stage) stages = part_named(part).stages(scenes);
  }
  for (std::unique_ptr<Stage>& stage : stages) {
    if (stage->name() == name) return std::move(stage);
  }
  throw InputError("no stage is called \"" + printable(name) + "\"; there are " + names);
}

ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options) {
  return run_stages(stages_of_run(experiment), experiment, cache, options);
}

std::size_t report_experiment(const Experiment& experiment, const Cache& cache,
                              const ExperimentResults& results,
                              const std::filesystem::path& folder) {
  const auto sections = report_stages(stages_of_run(experiment), experiment, results, folder);
  const std::size_t undrawn = write_results(experiment, cache, results, sections, folder);
  std::printf("%s\nResults in %s\n", terminal_of(result_summary(results.rows)).c_str(),
              printable_path(folder.string()).c_str());
  return undrawn;
}

ChartTypes chart_types() {
  return {chart<BarChart>(), chart<HeatMapChart>(), chart<SpeedChart>(),
          chart<TrainingBudgetChart>()};
}

}  // namespace ertbench
