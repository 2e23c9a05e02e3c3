#pragma once

#include <Eigen/Core>

namespace ertbench {

/// A = vectors diag(values) vectors^T, values ascending.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Of a symmetric matrix, of which the lower triangle is read; compiled once.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

}  // namespace ertbench
