#include "forward/fem/lattice_green.h"

#include <cmath>
#include <numbers>

namespace ertbench {

LatticeGreen::LatticeGreen(int columns, int rows) {
  const int turns = 2 * rows;      // the period of the direction that is summed over
  const int period = 2 * columns;  // that of the other
  // g(a, b) = 1/turns * sum_p cos(2 pi p a / turns) h_p(b), with h_p the periodic solution of
  // (lambda_p - second difference) h = delta; lambda_p = 2 - 2 cos(2 pi p / turns) = 2 cosh t - 2.
  Eigen::MatrixXd cosines(turns + 1, turns);
  Eigen::MatrixXd profiles(turns, period + 1);
  for (int p = 0; p < turns; ++p) {
    const double half_angle = std::numbers::pi * p / turns;
    for (int a = 0; a <= turns; ++a) {
      // The product p * a is reduced first so that the cosine's argument stays small.
      cosines(a, p) = std::cos(2 * std::numbers::pi * ((p * a) % turns) / turns) / turns;
    }
    const double t = 2 * std::asinh(std::sin(half_angle));
    for (int b = 0; b <= period; ++b) {
      if (p == 0) {  // zero mean takes the place of the missing decay
        profiles(p, b) = b * (b - double(period)) / (2.0 * period) +
                         (double(period) * period - 1) / (12.0 * period);
      } else {
        // cosh((period/2 - b) t) / (2 sinh t sinh(period/2 t)), written so as not to overflow
        profiles(p, b) = (std::exp(-b * t) + std::exp(-(period - b) * t)) /
                         (2 * std::sinh(t) * -std::expm1(-period * t));
      }
    }
  }
  table_.noalias() = cosines * profiles;
}

}  // namespace ertbench
