#pragma once

#include <Eigen/Core>
#include <optional>

#include "forward/sheet/sensor.h"

/// Sums over the pixels of an image of changes [pixels], S/m; C4 and D.1 are numbers in the
/// supplement of the DD-ERT paper (Zheng et al.).
namespace ertbench {

/// Of the background; an image that nowhere exceeds it is empty: far above the rounding of the
/// voltages, far below any contact.
inline constexpr double kEmptyImage = 1e-9;
/// Keeps a pixel that is exactly on a threshold in, whatever the rounding of its value.
inline constexpr double kThresholdSlack = 1e-9;

/// Whether no |change| is above kEmptyImage of the background.
bool is_empty(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change);

/// Whether positive and negative parts are equal to a thousandth: |sum| <= 1e-3 sum|.|. Such
/// weights have no centroid.
bool cancels(const Eigen::Ref<const Eigen::RowVectorXd>& weights);

/// `change` with everything under `fraction` of its largest absolute value set to zero (D.1).
Eigen::RowVectorXd thresholded(const Eigen::Ref<const Eigen::RowVectorXd>& change, double fraction);

/// Centroid of the pixel centres weighted by `change` (C4), domain units; nothing where the weights
/// cancel.
std::optional<Eigen::Vector2d> centroid(const Sensor& sensor,
                                        const Eigen::Ref<const Eigen::RowVectorXd>& change);

}  // namespace ertbench
