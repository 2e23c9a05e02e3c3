#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "forward/sheet/sheet.h"

/// The areas x areas equal rectangles into which D.2 and D.5 of the paper divide a sheet. Area 0 is
/// at the least x and y; the areas of a row, along x, follow each other.
namespace ertbench {

/// The area in which a place lies, mm from the origin of the domain units; of places beyond the
/// bounds of the sheet the nearest.
int area_of(const Sheet& sheet, const Eigen::Vector2d& place_mm, int areas = 5);

/// [areas²] the orbit of each area, from 0: the symmetries of the sheet take the areas of an orbit
/// into each other, so that a touch should be felt alike in all of them. Outer rings are counted
/// first, and in a ring what is farther from the middle: of the square's 5 x 5 areas corners (4),
/// beside the corners (8), edge middles (4), inner diagonal (4), inner straight (4), centre (1).
std::vector<int> area_orbits(const Sheet& sheet, int areas = 5);

/// The name of an orbit: "I" of 0, "II" of 1, ... Throws std::invalid_argument below 0.
std::string roman(int orbit);

}  // namespace ertbench
