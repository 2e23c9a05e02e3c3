#include "bench/features/features.h"

#include <utility>

#include "bench/report/bar_chart.h"
#include "bench/report/heat_map_chart.h"
#include "bench/run/accuracy_stage.h"
#include "bench/run/results.h"
#include "bench/run/timing_stage.h"
#include "bench/speed/speed_chart.h"
#include "bench/training/training_budget.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {

Stages stages_of_run(const Experiment& experiment, Machines machines) {
  Stages stages;
  stages.push_back(std::make_unique<AccuracyStage>());
  stages.push_back(std::make_unique<TimingStage>(machines));
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
  return report_results(experiment, cache, results, sections, folder);
}

namespace {

template <typename T>
ChartType chart() {
  return {T::type, [](const ChartRequest& request) { return std::make_shared<const T>(request); }};
}

}  // namespace

ChartTypes chart_types() {
  return {chart<BarChart>(), chart<HeatMapChart>(), chart<SpeedChart>(),
          chart<TrainingBudgetChart>()};
}

}  // namespace ertbench
