#include "bench/run/stages.h"

#include <iterator>

#include "bench/run/accuracy_stage.h"
#include "bench/run/fidelity_stage.h"
#include "bench/run/folds_stage.h"
#include "bench/run/ladder_stage.h"
#include "bench/run/study_stage.h"
#include "bench/run/timing_stage.h"
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

}  // namespace ertbench
