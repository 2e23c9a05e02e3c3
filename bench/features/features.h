#pragma once

#include <memory>
#include <string>

#include "bench/experiment/experiment_charts.h"
#include "bench/features/parts.h"
#include "bench/run/runner.h"
#include "bench/run/stage.h"
#include "bench/run/timing_stage.h"

namespace ertbench {

/// The stages of `ertbench run` on the experiment, each after those whose results it needs.
/// `machines`: whose times are taken as they are. Loads the part "ladders" where the experiment has
/// ladders, and "studies" where it has studies or folds.
Stages stages_of_run(const Experiment& experiment, Machines machines = Machines::this_one);
/// Scenes of each dataset that the models of the sheet are compared on, where nobody says.
inline constexpr int fidelity_usual_scenes = 500;
/// The stage of `ertbench fidelity`, on so many scenes of each dataset. Loads the part "tools".
Stages stages_of_fidelity(int scenes);

/// The stage of this name, whichever command has it. Throws InputError where there is none.
/// `scenes`: for fidelity.
std::unique_ptr<Stage> stage_named(const std::string& name, int scenes);

/// Runs all stages of `ertbench run` (run_stages).
ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options);

/// Has all stages of `ertbench run` report, then writes tables, figures and the page of the
/// experiment, and prints the table. Returns how many figures could not be drawn.
std::size_t report_experiment(const Experiment& experiment, const Cache& cache,
                              const ExperimentResults& results,
                              const std::filesystem::path& folder);

/// All charts that an experiment can ask for.
ChartTypes chart_types();

}  // namespace ertbench
