#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// When an image counts as a failure.
struct FailureRule {
  double relative_error = 1;       ///< of dσ: as much as the empty image has, or more
  double distance = 0.25;          ///< of the strongest contact from a true one, domain units
  double contact_threshold = 0.1;  ///< largest |dσ^| over the background that shows a contact
  double share = 0.05;             ///< of failing frames, above which a solver has broken down
};

/// How an image fails; several at once are possible.
enum class FailureKind { undefined = 1, worse_than_nothing = 2, misplaced = 4, ghost = 8 };

inline constexpr std::array kFailureKinds = {FailureKind::undefined,
                                             FailureKind::worse_than_nothing,
                                             FailureKind::misplaced, FailureKind::ghost};

/// "undefined", "worse than nothing", "misplaced", "contact where there is none".
const char* name_of(FailureKind kind);

/// One image held against the rule.
struct JudgedFrame {
  std::optional<double> error;     ///< relative error of dσ; none for blank scenes
  std::optional<double> distance;  ///< of the strongest contact from a true one, domain units
  std::optional<double> peak;      ///< largest |dσ^| over the background
  FrameStatus status = FrameStatus::ok;
  int failed = 0;  ///< sum of the FailureKinds

  bool has(FailureKind kind) const { return (failed & static_cast<int>(kind)) != 0; }
};

/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// An image is undefined where the solver says so or a pixel is not finite. Its strongest contact
/// is the region of pixels joined by their edges, around the pixel of the largest |dσ^|, where
/// |dσ^| is at least half of that; its place is the region's centroid. A scene whose true image is
/// that of the untouched sheet is blank: an image of it fails where it shows a contact, and by
/// nothing else. An image of zeros shows no contact: where there is one, its error is 1, which
/// fails.
JudgedFrame judge(const Sensor& sensor, const FailureRule& rule, const Scene& scene,
                  const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                  const Eigen::Ref<const Eigen::RowVectorXd>& change, FrameStatus status);

/// From a point to the nearest one of the contact's area, 0 inside; domain units. Ellipses are
/// polygons of 180 corners.
double distance_to(const Contact& contact, const Eigen::Vector2d& point);

}  // namespace ertbench
