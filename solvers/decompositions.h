#pragma once

#include <Eigen/Core>

namespace ertbench {

/// A = left diag(values) right^T, values descending; left [rows, min], right [columns, min].
struct DenseSvd {
  Eigen::MatrixXd left;
  Eigen::VectorXd values;
  Eigen::MatrixXd right;
};

/// Thin singular value decomposition by Eigen's divide and conquer. Compiled in one place, because
/// the templates take half a minute.
DenseSvd dense_svd(const Eigen::MatrixXd& matrix);

/// A = vectors diag(values) vectors^T, values ascending.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Eigendecomposition of a symmetric matrix; reads its lower triangle. Compiled in one place.
SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix);

}  // namespace ertbench
