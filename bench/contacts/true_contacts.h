#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Centroids of the scene's contacts that lie on the sheet, mm from the origin of the domain units.
std::vector<Eigen::Vector2d> true_places_mm(const Sensor& sensor, const Scene& scene);

/// Of contacts that were found, in the same unit.
std::vector<Eigen::Vector2d> places_mm(const Sensor& sensor, std::span<const FoundContact> found);

}  // namespace ertbench
