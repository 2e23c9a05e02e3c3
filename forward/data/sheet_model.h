#pragma once

#include <Eigen/Core>
#include <string>
#include <variant>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Voltages from finite elements on a grid of `side` x `side` pixels.
struct GridSheet {
  int side = 24;

  bool operator==(const GridSheet&) const = default;
};

/// Voltages of the continuous sheet, with as many points on the contacts' borders as each scene
/// needs.
struct ContinuousSheet {
  double model_error = 0.25;  ///< largest error of a frame, as a fraction of its noise (2-norms)

  bool operator==(const ContinuousSheet&) const = default;
};

using SheetModel = std::variant<GridSheet, ContinuousSheet>;

/// The value of "grid": "24", "auto".
inline std::string text_of(const SheetModel& model) {
  const auto* grid = std::get_if<GridSheet>(&model);
  return grid ? std::to_string(grid->side) : "auto";
}

/// Largest allowed error of a set, as a fraction of a frame's noise; the default for a grid.
inline double model_error_of(const SheetModel& model) {
  const auto* sheet = std::get_if<ContinuousSheet>(&model);
  return sheet ? sheet->model_error : ContinuousSheet{}.model_error;
}

// Uniform sheet: by the grid model if it applies (fits_grid), as for EIDORS's `d2s`, else by the
// border model, which applies to every sensor; its first use is reported on stderr.

/// Reference voltages of the uniform sheet, [channels] V.
Eigen::VectorXd uniform_reference(const Sensor& sensor);
/// Jacobian dV/dsigma [channels, pixels] of the uniform sheet in V per S/m; zero off the sheet.
RowMajorMatrix uniform_jacobian(const Sensor& sensor);

}  // namespace ertbench
