#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/ladder/ladder_results.h"
#include "bench/record/result_row.h"
#include "bench/report/report.h"

namespace ertbench {

/// Draws one axis for all solvers that climbed it, as `stem`.svg and `stem`.png: above, the share
/// of failing frames over the level, with the limit beyond which a solver fails; below, the median
/// relative error with whiskers from 5 to 95 %. The mildest level is on the left. More than eight
/// solvers are divided among several columns with the same axes. Throws InputError if gnuplot is
/// missing or a file cannot be written.
void draw_ladder_chart(const Ladders& ladders, const LadderAxis& axis,
                       const std::vector<LadderOutcome>& outcomes,
                       const std::filesystem::path& stem);

/// Writes breakdown.csv, breakdown.md, levels.csv, detection.csv, detection.md, a chart of each
/// axis, `ladder_`axis.svg and .png, the map breakdown.svg and .png and the gallery
/// worst_frames.svg and .png into `folder`. Returns their sections of the report; none if the
/// experiment has no ladders.
std::vector<ReportSection> write_ladder_results(const Experiment& experiment,
                                                const std::vector<LadderOutcome>& outcomes,
                                                const Builds& builds,
                                                const std::filesystem::path& folder);

}  // namespace ertbench
