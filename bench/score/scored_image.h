#pragma once

#include <Eigen/Core>
#include <optional>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// One image beside the truth: what the formulas of the metrics are given. All pixels are finite.
struct ScoredImage {
  const Sensor& sensor;
  const Scene& scene;
  const Eigen::RowVectorXd& conductivity;  ///< [pixels] S/m, true
  const Eigen::RowVectorXd& true_change;   ///< [pixels] S/m
  const Eigen::RowVectorXd& change;        ///< [pixels] S/m, estimated

  bool truth_is_empty() const;
  bool is_empty() const;
};

/// Whether no |change| is above 1e-9 of the background: far above the rounding of the voltages, far
/// below any contact.
bool is_empty(const Sensor& sensor, const Eigen::RowVectorXd& change);

/// (C2) of one image of changes, %; undefined of an empty image.
std::optional<double> resolution_of(const Sensor& sensor, const Eigen::RowVectorXd& change);

}  // namespace ertbench
