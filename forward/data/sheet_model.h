#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

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

/// What linear methods know of a sensor: voltages and Jacobian of its uniform sheet. By the grid
/// model where that serves (fits_grid), as it does for EIDORS's `d2s`; else by the border model,
/// which serves every sensor. The first time that it steps in, a line on stderr says so.

/// [channels] V.
Eigen::VectorXd uniform_reference(const Sensor& sensor);
/// dV/dsigma [channels, pixels] in V per S/m; zero for pixels off the sheet.
RowMajorMatrix uniform_jacobian(const Sensor& sensor);

}  // namespace ertbench
