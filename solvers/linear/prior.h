#pragma once

#include <Eigen/Core>
#include <string>

namespace ertbench {

/// The matrix R^T R of (A4), as in EIDORS: the identity; diag(J^T J)^(1/2) (NOSER); twice the
/// Laplacian of the pixel graph, pixels being neighbours across an edge.
enum class Prior { tikhonov, noser, laplace };

Prior prior_from_name(const std::string& name);  ///< "tikhonov", "noser", "laplace"
const char* name_of(Prior prior);

/// J [m, pixels] -> R^T R [pixels, pixels]; `columns` of the image, 0 of a square one.
Eigen::MatrixXd prior_matrix(Prior prior, const Eigen::MatrixXd& jacobian, int columns = 0);

/// The same by its factors: the image is E y + c 1 with |R(E y + c 1)| = |y|; c only where R^T R
/// maps constant images to zero.
struct PriorFactors {
  Eigen::MatrixXd shaping;  ///< E [pixels, number of y]
  bool free_constant;
};

PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns = 0);

}  // namespace ertbench
