#pragma once

#include <Eigen/Core>

namespace ertbench {

/// d/ds at `count` equidistant points of a closed curve, s in [0, 1], of the trigonometric
/// polynomial through their values: [count, count].
Eigen::MatrixXd closed_differentiation(int count);

/// The same at the midpoints of `count` equal stretches of an open one, of the cosine polynomial
/// through them: for what has no slope in s at the ends.
Eigen::MatrixXd open_differentiation(int count);

}  // namespace ertbench
