#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/experiment/experiment_charts.h"
#include "bench/run/stage.h"
#include "bench/run/timing_stage.h"

namespace ertbench {

using Stages = std::vector<std::unique_ptr<Stage>>;

/// The stages of `ertbench run`, each after those whose results it needs. `machines`: whose times
/// are taken as they are.
Stages stages_of_run(Machines machines = Machines::this_one);
/// Scenes of each dataset that the models of the sheet are compared on, where nobody says.
inline constexpr int fidelity_usual_scenes = 500;
/// That of `ertbench fidelity`, on so many scenes of each dataset.
Stages stages_of_fidelity(int scenes);

/// The stage of this name, whichever command has it. Throws InputError where there is none.
/// `scenes`: for fidelity.
std::unique_ptr<Stage> stage_named(const std::string& name, int scenes);

/// All charts that an experiment can ask for.
ChartTypes chart_types();

}  // namespace ertbench
