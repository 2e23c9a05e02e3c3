#pragma once

#include <Eigen/Core>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What linear methods know of a sensor: voltages and Jacobian of its uniform sheet. By the grid
/// model where that serves (fits_grid), as it does for EIDORS's `d2s`; else by the border model,
/// which serves every sensor. The first time that it steps in, a line on stderr says so.

/// [channels] V.
Eigen::VectorXd uniform_reference(const Sensor& sensor);
/// dV/dsigma [channels, pixels] in V per S/m; zero for pixels off the sheet.
RowMajorMatrix uniform_jacobian(const Sensor& sensor);

}  // namespace ertbench
