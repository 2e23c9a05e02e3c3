#pragma once

#include <complex>

#include "forward/sheet/sheet.h"

namespace ertbench {

/// The conformal map of the rectangle [-a, a] x [-b, b] onto the unit disc, the middle to 0 (see
/// SquareMap for what it is good for).
///
/// sn takes a rectangle to the half plane and a Moebius map that to the disc. With the theta
/// functions of nome q = exp(-2 pi L), L = longer / shorter side, and v = pi z / (2 s) + i pi L /
/// 2, s half the shorter side, which lies along the real axis (the plane is turned where it does
/// not),
///
///     w = (theta_1(v) - i theta_4(v)) / (theta_1(v) + i theta_4(v)),
///     w' = 2 i theta_4(0)^2 theta_2(v) theta_3(v) / (theta_1(v) + i theta_4(v))^2,
///
/// by the ratio's derivative (theta_1 / theta_4)' = theta_4(0)^2 theta_2 theta_3 / theta_4^2.
/// Turned like this q is at most exp(-2 pi), and four terms are exact. Analytic beyond the border.
class RectangleMap {
 public:
  RectangleMap(double half_width, double half_height);

  DiscPoint operator()(std::complex<double> z) const;

 private:
  bool turned_;
  double scale_;  ///< v = scale z + i lift
  double lift_;
  double nome_;
  double squared_theta_;  ///< theta_4(0)^2
};

}  // namespace ertbench
