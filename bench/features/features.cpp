#include "bench/features/features.h"

#include <iterator>

#include "bench/fidelity/fidelity_stage.h"
#include "bench/folds/folds_stage.h"
#include "bench/ladder/ladder_stage.h"
#include "bench/report/bar_chart.h"
#include "bench/report/heat_map_chart.h"
#include "bench/run/accuracy_stage.h"
#include "bench/run/results.h"
#include "bench/run/timing_stage.h"
#include "bench/speed/speed_chart.h"
#include "bench/studies/study.h"
#include "bench/training/training_budget.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {

Stages stages_of_run(Machines machines) {
  Stages stages;
  stages.push_back(std::make_unique<AccuracyStage>());
  stages.push_back(std::make_unique<TimingStage>(machines));
  stages.push_back(std::make_unique<LadderStage>());
  stages.push_back(std::make_unique<FoldsStage>());
  stages.push_back(std::make_unique<StudyStage>());
  return stages;
}

Stages stages_of_fidelity(int scenes) {
  Stages stages;
  stages.push_back(std::make_unique<FidelityStage>(scenes));
  return stages;
}

std::unique_ptr<Stage> stage_named(const std::string& name, int scenes) {
  Stages all = stages_of_run();
  Stages more = stages_of_fidelity(scenes);
  std::move(more.begin(), more.end(), std::back_inserter(all));
  std::string names;
  for (std::unique_ptr<Stage>& stage : all) {
    if (stage->name() == name) return std::move(stage);
    names += (names.empty() ? "" : ", ") + stage->name();
  }
  throw InputError("no stage is called \"" + printable(name) + "\"; there are " + names);
}

ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options) {
  return run_stages(stages_of_run(), experiment, cache, options);
}

std::size_t report_experiment(const Experiment& experiment, const Cache& cache,
                              const ExperimentResults& results,
                              const std::filesystem::path& folder) {
  const auto sections = report_stages(stages_of_run(), experiment, results, folder);
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
