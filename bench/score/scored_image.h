#pragma once

#include <Eigen/Core>
#include <optional>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

struct ContactScore;

/// One image beside the truth: what the formulas of the metrics are given. All pixels are finite.
struct ScoredImage {
  const Sensor& sensor;
  const Scene& scene;
  const Eigen::RowVectorXd& conductivity;  ///< [pixels] S/m, true
  const Eigen::RowVectorXd& true_change;   ///< [pixels] S/m
  const Eigen::RowVectorXd& change;        ///< [pixels] S/m, estimated
  const ContactScore& contacts;            ///< for metrics of contacts alone

  bool truth_is_empty() const;
  bool is_empty() const;
};

/// Where the contacts are: the centre of a contact that is alone and whole on the sheet, else the
/// centroid of the true change (C4), domain units; nothing where that has none.
std::optional<Eigen::Vector2d> true_centre(const Sensor& sensor, const Scene& scene,
                                           const Eigen::RowVectorXd& true_change);

/// (C2) of one image of changes, %; undefined of an empty image.
std::optional<double> resolution_of(const Sensor& sensor, const Eigen::RowVectorXd& change);

}  // namespace ertbench
