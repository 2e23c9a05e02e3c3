#pragma once

#include <Eigen/Core>

namespace ertbench {

/// d/ds at `count` equidistant points of a closed curve, s in [0, 1], of the trigonometric
/// polynomial through their values: [count, count].
Eigen::MatrixXd closed_differentiation(int count);

}  // namespace ertbench
