#pragma once

#include <Eigen/Core>

#include "forward/sheet/rasterise.h"
#include "forward/sheet/sensor.h"

namespace ertbench::testing {

inline const Sensor kSensor;  ///< the default sheet

/// A disc of the given conductivity / background, in domain units.
inline Contact disc(double x, double y, double radius = 0.15, double ratio = 0.6) {
  Contact contact;
  contact.centre = {x, y};
  contact.half_size = {radius, radius};
  contact.conductivity_ratio = ratio;
  return contact;
}

/// [pixels] S/m on the image of kSensor.
inline Eigen::RowVectorXd true_image(const Scene& scene) {
  Eigen::VectorXd ratio(kSensor.pixels());
  rasterise(scene, kSensor.image(), Rasterisation::area, ratio);
  return kSensor.background * ratio.transpose();
}

/// Its change, [pixels] S/m.
inline Eigen::RowVectorXd true_change(const Scene& scene) {
  return true_image(scene).array() - kSensor.background;
}

}  // namespace ertbench::testing
