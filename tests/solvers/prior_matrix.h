#pragma once

#include <Eigen/Core>
#include <cmath>

#include "solvers/linear/masked_inverse.h"

namespace ertbench::testing {

/// R^T R [pixels, pixels] of a square image by its definition, for J [m, pixels].
inline Eigen::MatrixXd prior_matrix(Prior prior, const Eigen::MatrixXd& jacobian) {
  const Eigen::Index pixels = jacobian.cols();
  if (prior == Prior::tikhonov) return Eigen::MatrixXd::Identity(pixels, pixels);
  if (prior == Prior::noser) {
    return Eigen::VectorXd(jacobian.colwise().norm().transpose()).asDiagonal();
  }
  const Eigen::Index n = std::lround(std::sqrt(static_cast<double>(pixels)));
  Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(pixels, pixels);
  const auto join = [&](Eigen::Index p, Eigen::Index q) {
    laplacian(p, p) += 1;
    laplacian(q, q) += 1;
    laplacian(p, q) -= 1;
    laplacian(q, p) -= 1;
  };
  for (Eigen::Index p = 0; p < pixels; ++p) {
    if (p % n < n - 1) join(p, p + 1);
    if (p / n < n - 1) join(p, p + n);
  }
  return 2 * laplacian;
}

}  // namespace ertbench::testing
