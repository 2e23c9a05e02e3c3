#pragma once

#include <Eigen/Core>

namespace ertbench {

/// a = sum_i values[i] left.col(i) right.col(i)^T, values descending.
struct SingularTriplets {
  Eigen::VectorXd values;  ///< [k]
  Eigen::MatrixXd left;    ///< [rows of a, k]
  Eigen::MatrixXd right;   ///< [columns of a, k]
};

/// The `count` leading singular triplets of `a`, fewer where the rank of `a` (values above 1e-13 of
/// the largest) is less. Errors are of the order of rounding in the largest value.
///
/// Spectra finds them as eigenpairs of the symmetric [0 C; C^T 0], with C the triangular factor of
/// `a`, whose condition is that of `a` and not its square. A Krylov space holds one vector of each
/// eigenspace, and the symmetries of the sensor make values double: what was found is deflated and
/// the search repeated until nothing is left above the smallest value returned.
/// Throws std::runtime_error where a residual is not small: a defect.
SingularTriplets leading_singular_triplets(const Eigen::MatrixXd& a, Eigen::Index count);

}  // namespace ertbench
