#include "solvers/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

namespace ertbench {

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace ertbench
