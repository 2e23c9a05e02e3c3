#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "bench/ladder/ladder_results.h"
#include "bench/report/heat_map.h"

namespace ertbench {

/// Solvers across, axes of the scenes that have an order up: where on its ladder each solver breaks
/// down, 0 at the mildest level to 1 at the severest, with the level in the cell. Nothing where no
/// axis has an order.
std::optional<HeatMap> ladder_map_of(const std::string& title,
                                     const std::vector<AxisBreakdown>& breakdowns);

/// A frame of the gallery.
struct GalleryFrame {
  const WorstFrame* frame = nullptr;
  const LadderAxis* axis = nullptr;
};

/// Four frames at most of a solver's ladders of the scenes: the worst of each kind of failure, then
/// the worst of the rest.
std::vector<GalleryFrame> gallery_of(const Ladders& ladders, const LadderRecord& record);

/// Draws the galleries of all solvers, a row for each: pairs of truth and image on a
/// scale of their own, with what failed and where. Nothing is drawn, and false returned, where no
/// solver has any. Throws InputError where gnuplot is missing or a file cannot be written.
bool draw_gallery(const Ladders& ladders, const std::vector<LadderOutcome>& outcomes,
                  const Sensor& sensor, const std::filesystem::path& stem);

}  // namespace ertbench
