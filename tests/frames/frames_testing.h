#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <vector>

#include "core/hdf5_file.h"
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

/// Where the image of a frame is strongest, mm.
inline Eigen::Vector2d strongest(const std::filesystem::path& images, std::uint64_t frame) {
  const Hdf5File file = Hdf5File::open(images);
  const Eigen::VectorXd x = file.read_vector("/x_mm");
  const Eigen::VectorXd y = file.read_vector("/y_mm");
  Eigen::Index at = 0;
  file.read_rows("/conductivity_change", frame, 1).row(0).cwiseAbs().maxCoeff(&at);
  return {x[at % x.size()], y[at / x.size()]};
}

}  // namespace ertbench::testing
