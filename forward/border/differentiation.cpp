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

}  // namespace ertbench
