#pragma once

#include <Eigen/Core>

namespace ertbench {

/// A = left diag(values) right^T, values descending; left [rows, min], right [columns, min].
struct DenseSvd {
  Eigen::MatrixXd left;
  Eigen::VectorXd values;
  Eigen::MatrixXd right;
};

/// Thin singular value decomposition by LAPACK's divide and conquer, on one thread. Throws
/// std::runtime_error where it does not converge, as with numbers that are not finite.
DenseSvd dense_svd(const Eigen::MatrixXd& matrix);

/// A = vectors diag(values) vectors^T, values ascending.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Eigendecomposition of a symmetric matrix; reads its lower triangle. Otherwise as dense_svd.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

}  // namespace ertbench
