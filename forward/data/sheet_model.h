#pragma once

#include <string>
#include <variant>

namespace ertbench {

/// The voltages of a set come from finite elements on a grid of `side` x `side` pixels.
struct GridSheet {
  int side = 24;

  bool operator==(const GridSheet&) const = default;
};

/// They come from the continuous sheet, scene by scene with as many points on the contacts' borders
/// as it needs.
struct ContinuousSheet {
  double model_error = 0.25;  ///< largest error of a frame, as a fraction of its noise (2-norms)

  bool operator==(const ContinuousSheet&) const = default;
};

using SheetModel = std::variant<GridSheet, ContinuousSheet>;

/// As "grid" has it: "24", "auto".
inline std::string text_of(const SheetModel& model) {
  const auto* grid = std::get_if<GridSheet>(&model);
  return grid ? std::to_string(grid->side) : "auto";
}

/// The largest error that the set allows, as a fraction of a frame's noise. A set on a grid names
/// none, and is held against the default.
inline double model_error_of(const SheetModel& model) {
  const auto* sheet = std::get_if<ContinuousSheet>(&model);
  return sheet ? sheet->model_error : ContinuousSheet{}.model_error;
}

}  // namespace ertbench
