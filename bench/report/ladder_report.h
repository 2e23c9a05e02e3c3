#pragma once

#include <filesystem>
#include <vector>

#include "bench/analysis/ladder_results.h"
#include "bench/experiment/experiment.h"
#include "bench/record/builds_text.h"
#include "bench/report/report.h"

namespace ertbench {

/// Writes breakdown.csv, breakdown.md, levels.csv, detection.csv, detection.md, a chart of each
/// axis, `ladder_`axis.svg and .png, the map breakdown.svg and .png and the gallery
/// worst_frames.svg and .png into `folder`.
/// Returns their sections of the report; none where the experiment has no ladders.
std::vector<ReportSection> write_ladder_results(const Experiment& experiment,
                                                const std::vector<LadderOutcome>& outcomes,
                                                const Builds& builds,
                                                const std::filesystem::path& folder);

}  // namespace ertbench
