#pragma once

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// dV/dsigma [channels, pixels] in V per S/m of the uniform sheet, of the sensor's image, without a
/// mesh:
///
///     dV(d, m)/dsigma_p = I / c0^2  int over pixel p of grad u_d . grad u_m,
///
/// u by unit current on a sheet of conductivity 1, a sum of Neumann functions of the electrodes
/// (DiscElectrodes), whose product of gradients the conformal map keeps. By Gauss points, in boxes
/// that are halved towards electrodes and towards the sheet's border, over the part of the pixel
/// that is on the sheet; zero for pixels off it.
RowMajorMatrix border_jacobian(const Sensor& sensor);

/// The mean of a pixel's sensitivity is what the integral finds; this is the integral's density at
/// a place on the sheet: dV/dsigma per unit area (squared domain units), [channels].
Eigen::VectorXd border_sensitivity(const Sensor& sensor, const Eigen::Vector2d& place);

}  // namespace ertbench
