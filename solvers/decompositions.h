#pragma once

#include <Eigen/Core>

namespace ertbench {

/// A = left diag(values) right^T, values descending; left [rows, min], right [columns, min].
struct DenseSvd {
  Eigen::MatrixXd left;
  Eigen::VectorXd values;
  Eigen::MatrixXd right;
};

/// Eigen's divide and conquer, compiled once: its templates take half a minute.
DenseSvd dense_svd(const Eigen::MatrixXd& matrix);

/// A = vectors diag(values) vectors^T, values ascending.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Of a symmetric matrix, of which the lower triangle is read; compiled once.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

}  // namespace ertbench
