#include "solvers/linear/masked_inverse.h"

#include <Eigen/Cholesky>
#include <utility>

#include "solvers/symmetric_eigen.h"

namespace ertbench {

MaskedGaussNewton::MaskedGaussNewton(const Eigen::MatrixXd& jacobian, const PriorFactors& prior,
                                     double lambda)
    : square_(lambda * lambda) {
  const Eigen::MatrixXd shaped = jacobian * prior.shaping;
  gram_ = shaped * shaped.transpose();
  basis_ = prior.shaping * shaped.transpose();
  if (prior.free_constant) {
    constant_ = jacobian.rowwise().sum();
    basis_.conservativeResize(Eigen::NoChange, basis_.cols() + 1);
    basis_.rightCols(1).setOnes();
  }
}

Eigen::MatrixXd MaskedGaussNewton::weights(const std::vector<Eigen::Index>& kept) const {
  const auto count = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(basis_.cols(), gram_.cols());
  if (count == 0) return out;
  Eigen::MatrixXd matrix = gram_(kept, kept);
  matrix.diagonal().array() += square_;
  const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
  Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(count, count));
  if (constant_.size() > 0) {
    const Eigen::VectorXd k = constant_(kept);
    const Eigen::VectorXd solved = factor.solve(k);
    const Eigen::RowVectorXd c = solved.transpose() / k.dot(solved);
    inverse -= solved * c;
    out.bottomRows(1)(Eigen::all, kept) = c;
  }
  out(kept, kept) = inverse;
  return out;
}

MaskedTsvd::MaskedTsvd(const Eigen::MatrixXd& jacobian, double least)
    : gram_(jacobian * jacobian.transpose()), least_(least) {
  basis_ = jacobian.transpose();
}

Eigen::MatrixXd MaskedTsvd::weights(const std::vector<Eigen::Index>& kept) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(gram_.rows(), gram_.cols());
  if (kept.empty()) return out;
  const SymmetricEigen eigen = symmetric_eigen(gram_(kept, kept));
  const double least = least_ * least_ * (1 - 1e-9);
  const auto rank = (eigen.values.array() >= least).count();
  const auto vectors = eigen.vectors.rightCols(rank);
  out(kept, kept) =
      vectors * eigen.values.tail(rank).cwiseInverse().asDiagonal() * vectors.transpose();
  return out;
}

MaskedMmse::MaskedMmse(Eigen::MatrixXd changes, const Eigen::MatrixXd& cross, double ridge)
    : changes_(std::move(changes)), ridge_(ridge) {
  basis_ = cross;
}

Eigen::MatrixXd MaskedMmse::weights(const std::vector<Eigen::Index>& kept) const {
  const auto count = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(changes_.rows(), changes_.cols());
  if (count == 0) return out;
  Eigen::MatrixXd matrix = changes_(kept, kept);
  matrix.diagonal().array() += ridge_ * matrix.diagonal().mean();
  const Eigen::MatrixXd inverse = matrix.llt().solve(Eigen::MatrixXd::Identity(count, count));
  out(kept, kept) = inverse;
  return out;
}

}  // namespace ertbench
