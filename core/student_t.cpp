#include "core/student_t.h"

#include <cmath>
#include <stdexcept>
#include <unsupported/Eigen/SpecialFunctions>

namespace ertbench {
namespace {

/// P(T > t) for t >= 0 (Abramowitz and Stegun 26.7.1, as an incomplete beta function).
double upper_tail(double t, int degrees_of_freedom) {
  const double n = degrees_of_freedom;
  return 0.5 * Eigen::numext::betainc(n / 2, 0.5, n / (n + t * t));
}

}  // namespace

double student_t_quantile(double probability, int degrees_of_freedom) {
  if (!(probability > 0 && probability < 1) || degrees_of_freedom < 1) {
    throw std::invalid_argument("student_t_quantile: needs 0 < probability < 1, degrees >= 1");
  }
  if (probability < 0.5) return -student_t_quantile(1 - probability, degrees_of_freedom);
  double low = 0;
  double high = 1;
  while (upper_tail(high, degrees_of_freedom) > 1 - probability) high *= 2;
  while (high - low > 1e-12 * high) {
    const double middle = (low + high) / 2;
    if (middle == low || middle == high) break;
    (upper_tail(middle, degrees_of_freedom) > 1 - probability ? low : high) = middle;
  }
  return high;
}

}  // namespace ertbench
