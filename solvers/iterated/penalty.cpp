#include "solvers/iterated/penalty.h"

#include <cmath>

namespace ertbench {

void ShapedPenalty::image(const Eigen::VectorXd& z, Eigen::VectorXd& t) const {
  if (shaping_.cols() == 1) {
    t = shaping_.col(0).cwiseProduct(z);
  } else {
    t.noalias() = shaping_ * z;
  }
}

bool ShapedPenalty::minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                             const Eigen::VectorXd&, Eigen::VectorXd& z) {
  shaped_.resize(jacobian.rows(), coordinates());
  if (shaping_.cols() == 1) {
    shaped_ = jacobian.array().rowwise() * shaping_.col(0).transpose().array();
  } else {
    shaped_.noalias() = jacobian * shaping_;
  }
  gram_.setZero(jacobian.rows(), jacobian.rows());
  gram_.selfadjointView<Eigen::Lower>().rankUpdate(shaped_);
  gram_.diagonal().array() += lambda_ * lambda_;
  factor_.compute(gram_);
  if (factor_.info() != Eigen::Success) return false;
  solved_ = data;
  factor_.solveInPlace(solved_);
  z.noalias() = shaped_.transpose() * solved_;
  return true;
}

EdgePenalty::EdgePenalty(int columns, int rows, double weight, double smoothing)
    : edges_(columns, rows),
      weight_(weight),
      smoothing_(smoothing),
      laplacian_(columns, rows),
      difference_(edges_.count()),
      curvature_(edges_.count()) {}

double EdgePenalty::value(const Eigen::VectorXd& z) {
  edges_.differences(z, difference_);
  if (smoothing_ <= 0) return weight_ * difference_.squaredNorm();
  return weight_ *
         ((difference_.array().square() + smoothing_ * smoothing_).sqrt() - smoothing_).sum();
}

bool EdgePenalty::minimise(const RowMajorMatrix& jacobian, const Eigen::VectorXd& data,
                           const Eigen::VectorXd& now, Eigen::VectorXd& z) {
  const Eigen::Index pairs = jacobian.rows();
  const Eigen::Index block = GridLaplacian::block;
  const Eigen::Index padded = (pairs + block - 1) / block * block;
  if (smoothing_ <= 0) {
    curvature_.setConstant(2 * weight_);
  } else {
    edges_.differences(now, difference_);
    curvature_ = weight_ * (difference_.array().square() + smoothing_ * smoothing_).rsqrt();
  }
  laplacian_.factor(edges_, curvature_);
  transposed_.resize(edges_.pixels(), padded);
  transposed_.leftCols(pairs) = jacobian.transpose();
  transposed_.rightCols(padded - pairs).setZero();
  half_.resize(edges_.pixels(), padded);
  laplacian_.half_solve(transposed_, padded, half_);

  const Eigen::Index unknowns = laplacian_.unknowns();
  const auto half = half_.topLeftCorner(unknowns, pairs);
  schur_.setIdentity(pairs, pairs);
  schur_.selfadjointView<Eigen::Lower>().rankUpdate(half.transpose());
  factor_.compute(schur_);
  if (factor_.info() != Eigen::Success) return false;
  constant_ = jacobian.rowwise().sum();
  constant_solve_ = constant_;
  factor_.solveInPlace(constant_solve_);
  solved_ = data;
  factor_.solveInPlace(solved_);
  const double c = constant_.dot(solved_) / constant_.dot(constant_solve_);
  solved_ -= c * constant_solve_;
  z.resize(edges_.pixels());
  z.head(unknowns).noalias() = half * solved_;
  laplacian_.half_solve_transposed(z);
  z[unknowns] = 0;
  z.array() += c;
  return true;
}

}  // namespace ertbench
