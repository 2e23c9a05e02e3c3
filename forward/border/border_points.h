#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/border/contact_arcs.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// Quadrature points on the borders of the contacts, mapped onto the unit disc. A closed border has
/// points at equal parameters, which converge spectrally; a stretch between corners or junctions
/// has the midpoint rule in s with the parameter s^p / (s^p + (1 - s)^p) (Kress 1990), p the arc's
/// grading, whose points gather at the ends, where the density is singular. All arrays [points].
struct BorderPoints {
  Eigen::ArrayXd x, y;                ///< position
  Eigen::ArrayXd normal_x, normal_y;  ///< unit normal to the right of the direction of travel
  Eigen::ArrayXd curvature;           ///< counter-clockwise positive
  Eigen::ArrayXd weight;              ///< arc length that the point stands for
  Eigen::ArrayXd depth;               ///< 1 - |w|^2, 0 on the sheet's border
  std::vector<int> arc;               ///< to which each belongs
  std::vector<int> first;             ///< [arcs + 1] index of each arc's first point

  Eigen::Index size() const { return x.size(); }
};

/// `counts` [arcs]: points on each.
BorderPoints border_points(const Sheet& sheet, const std::vector<ContactArc>& arcs,
                           const std::vector<int>& counts);

/// The parameter of point `index` of `count` on an arc, and how fast it runs with s in [0, 1].
struct Graded {
  double parameter, speed;
};
Graded graded_parameter(const ContactArc& arc, int index, int count);

}  // namespace ertbench
