#include "forward/border/differentiation.h"

#include <cmath>
#include <numbers>

namespace ertbench {

using Eigen::MatrixXd;
using std::numbers::pi;

MatrixXd closed_differentiation(int count) {
  MatrixXd out(count, count);
  Eigen::VectorXd by_distance = Eigen::VectorXd::Zero(count);
  for (int distance = 0; distance < count; ++distance) {
    for (int k = 1; 2 * k < count; ++k) {
      by_distance[distance] -= 4 * pi * k / count * std::sin(2 * pi * k * distance / count);
    }
  }
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) out(i, j) = by_distance[(i - j + count) % count];
  }
  return out;
}

MatrixXd open_differentiation(int count) {
  MatrixXd slopes(count, count);  // of the cosines k at the points i
  MatrixXd values(count, count);  // of the same at the points j, by their weights
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < count; ++i) {
      const double angle = pi * k * (i + 0.5) / count;
      slopes(i, k) = -pi * k * std::sin(angle);
      values(i, k) = 2.0 / count * std::cos(angle);
    }
  }
  return slopes * values.transpose();
}

}  // namespace ertbench
