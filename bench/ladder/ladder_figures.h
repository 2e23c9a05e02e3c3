#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "bench/ladder/ladder_results.h"
#include "bench/report/heat_map.h"

namespace ertbench {

/// Map of the levels at which solvers (columns) fail on the ordered axes of the scenes (rows): the
/// colour is 0 at the mildest level and 1 at the severest, the text is the level. Nothing if no
/// axis has an order.
std::optional<HeatMap> ladder_map_of(const std::string& title,
                                     const std::vector<AxisBreakdown>& breakdowns);

struct GalleryFrame {
  const WorstFrame* frame = nullptr;
  const LadderAxis* axis = nullptr;
};

/// Four frames at most of a solver's ladders of the scenes: the worst of each kind of failure, then
/// the worst of the rest.
std::vector<GalleryFrame> gallery_of(const Ladders& ladders, const LadderRecord& record);

/// Draws the galleries of all solvers, one row each: pairs of truth and image, each pair on its own
/// scale, with the failure and its level. Returns false, without drawing, if no solver has any.
/// Throws InputError if gnuplot is missing or a file cannot be written.
bool draw_gallery(const Ladders& ladders, const std::vector<LadderOutcome>& outcomes,
                  const Sensor& sensor, const std::filesystem::path& stem);

}  // namespace ertbench
