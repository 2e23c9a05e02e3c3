#pragma once

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "forward/border/border_model.h"
#include "forward/sheet/sensor.h"

namespace ertbench::testing {

/// The model's reference voltages with gains of their own, of a standard deviation of one per cent.
inline Eigen::VectorXd reference_with_gains(const Sensor& sensor, std::mt19937& random) {
  std::normal_distribution<double> gain(1, 0.01);
  Eigen::VectorXd reference = BorderModel(sensor).reference_voltages();
  for (double& v : reference) v *= gain(random);
  return reference;
}

/// A disc on the sheet, lengths in domain units.
inline Scene disc_at(double x, double y, double radius = 0.25, double ratio = 0.4) {
  Contact disc;
  disc.centre = {x, y};
  disc.half_size = {radius, radius};
  disc.conductivity_ratio = ratio;
  return {{disc}};
}

/// Changes of the voltages by discs at these places, [places, channels] V.
inline RowMajorMatrix changes_by_discs(const Sensor& sensor,
                                       const std::vector<Eigen::Vector2d>& places) {
  const BorderModel model(sensor);
  RowMajorMatrix out(static_cast<Eigen::Index>(places.size()), sensor.channels());
  for (std::size_t i = 0; i < places.size(); ++i) {
    out.row(static_cast<Eigen::Index>(i)) =
        model.solve_at(disc_at(places[i].x(), places[i].y()), 1).change.transpose();
  }
  return out;
}

}  // namespace ertbench::testing
