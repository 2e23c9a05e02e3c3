#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Symmetries of the sheet, about its centre and without the identity, that no voltages show: a
/// contact and its image give the same voltages, as with opposite drive and opposite measurement.
/// Compares the sensitivity of the channels at places and at their images.
std::vector<Eigen::Matrix2d> twin_symmetries(const Sensor& sensor);

/// Puts behind each contact its images at which it would give the same voltages.
void add_twins(const Sensor& sensor, const std::vector<Eigen::Matrix2d>& twins,
               std::vector<FoundContact>& contacts);

/// "(x, y) and (-x, -y) give the same voltages ..."; empty without a symmetry.
std::string text_of_twins(const std::vector<Eigen::Matrix2d>& symmetries);

}  // namespace ertbench
