#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Limits beyond which an image counts as a failure.
struct FailureRule {
  double relative_error = 1;       ///< of dσ; the empty image has 1, which fails
  double distance = 0.25;          ///< from the strongest contact to a true one, domain units
  double contact_threshold = 0.1;  ///< least peak |dσ^| over the background that shows a contact
  double share = 0.05;             ///< a solver fails beyond this share of failing frames
};

/// Kinds of failure, as bits: an image may fail in several ways.
enum class FailureKind { undefined = 1, worse_than_nothing = 2, misplaced = 4, false_positive = 8 };

inline constexpr std::array kFailureKinds = {FailureKind::undefined,
                                             FailureKind::worse_than_nothing,
                                             FailureKind::misplaced, FailureKind::false_positive};

/// One image judged by the rule.
struct JudgedFrame {
  std::optional<double> error;     ///< relative error of dσ; no value without a contact
  std::optional<double> distance;  ///< from the strongest contact to a true one, domain units
  std::optional<double> peak;      ///< largest |dσ^| over the background
  FrameStatus status = FrameStatus::ok;
  int failed = 0;  ///< sum of the FailureKinds

  bool has(FailureKind kind) const { return (failed & static_cast<int>(kind)) != 0; }
};

/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// An image is undefined if the solver says so or a pixel is not finite. Its strongest contact is
/// the region of edge-connected pixels around the largest |dσ^| with at least half of it; the
/// contact's position is the region's centroid. If the true image is that of the untouched sheet,
/// an image can only fail by showing a contact. An empty image of a scene with a contact fails: its
/// error is 1.
JudgedFrame judge(const Sensor& sensor, const FailureRule& rule, const Scene& scene,
                  const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                  const Eigen::Ref<const Eigen::RowVectorXd>& change, FrameStatus status);

/// Distance from `point` to the contact's area, 0 inside; domain units. Ellipses are approximated
/// by polygons of 180 corners.
double distance_to(const Contact& contact, const Eigen::Vector2d& point);

}  // namespace ertbench
