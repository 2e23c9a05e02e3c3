#include "solvers/linear/masked_inverse.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "solvers/decompositions.h"

namespace ertbench {
namespace {

/// Square root of the diagonal of J^T J.
Eigen::VectorXd sensitivities(const Eigen::MatrixXd& jacobian) {
  return jacobian.colwise().norm().transpose();
}

/// The Laplacian of a path of n pixels has the eigenvectors cos(pi k (i + 1/2) / n) and the
/// eigenvalues 2 - 2 cos(pi k / n). The grid's has products of the vectors and sums of the values.
PriorFactors laplace_factors(int columns, int rows) {
  const auto path_of = [](int n, Eigen::VectorXd& values) {
    Eigen::MatrixXd path(n, n);
    values.resize(n);
    for (int k = 0; k < n; ++k) {
      values[k] = 2 - 2 * std::cos(std::numbers::pi * k / n);
      for (int i = 0; i < n; ++i) path(i, k) = std::cos(std::numbers::pi * k * (i + 0.5) / n);
    }
    path.colwise().normalize();
    return path;
  };
  Eigen::VectorXd values_x;
  Eigen::VectorXd values_y;
  const Eigen::MatrixXd path_x = path_of(columns, values_x);
  const Eigen::MatrixXd path_y = path_of(rows, values_y);
  Eigen::MatrixXd shaping(columns * rows, columns * rows - 1);
  for (int mode = 1; mode < columns * rows; ++mode) {
    const int kx = mode % columns;
    const int ky = mode / columns;
    const double scale = 1 / std::sqrt(2 * (values_x[kx] + values_y[ky]));
    for (int row = 0; row < rows; ++row) {
      shaping.col(mode - 1).segment(row * columns, columns) =
          scale * path_y(row, ky) * path_x.col(kx);
    }
  }
  return {shaping, true};
}

/// Columns of the image; those of a square one if `columns` is 0.
int columns_of(const Eigen::MatrixXd& jacobian, int columns) {
  return columns > 0
             ? columns
             : static_cast<int>(std::lround(std::sqrt(static_cast<double>(jacobian.cols()))));
}

}  // namespace

Prior prior_from_name(const std::string& name) {
  for (const Prior prior : {Prior::tikhonov, Prior::noser, Prior::laplace}) {
    if (name == name_of(prior)) return prior;
  }
  throw std::invalid_argument("no prior is called " + name);
}

const char* name_of(Prior prior) {
  switch (prior) {
    case Prior::tikhonov:
      return "tikhonov";
    case Prior::noser:
      return "noser";
    default:
      return "laplace";
  }
}

Eigen::MatrixXd prior_matrix(Prior prior, const Eigen::MatrixXd& jacobian, int columns) {
  const Eigen::Index pixels = jacobian.cols();
  if (prior == Prior::tikhonov) return Eigen::MatrixXd::Identity(pixels, pixels);
  if (prior == Prior::noser) return sensitivities(jacobian).asDiagonal();
  const Eigen::Index n = columns_of(jacobian, columns);
  Eigen::MatrixXd laplacian = Eigen::MatrixXd::Zero(pixels, pixels);
  const auto join = [&](Eigen::Index p, Eigen::Index q) {
    laplacian(p, p) += 1;
    laplacian(q, q) += 1;
    laplacian(p, q) -= 1;
    laplacian(q, p) -= 1;
  };
  for (Eigen::Index p = 0; p < pixels; ++p) {
    if (p % n < n - 1) join(p, p + 1);
    if (p / n < pixels / n - 1) join(p, p + n);
  }
  return 2 * laplacian;
}

PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns) {
  const Eigen::Index pixels = jacobian.cols();
  if (prior == Prior::tikhonov) return {Eigen::MatrixXd::Identity(pixels, pixels), false};
  if (prior == Prior::laplace) {
    const int across = columns_of(jacobian, columns);
    return laplace_factors(across, static_cast<int>(pixels) / across);
  }
  // Pixels to which no channel is sensitive stay zero.
  const Eigen::VectorXd s = sensitivities(jacobian);
  const double unseen = 1e-14 * s.maxCoeff();
  const Eigen::VectorXd shaping =
      s.unaryExpr([unseen](double v) { return v > unseen ? 1 / std::sqrt(v) : 0.0; });
  return {shaping.asDiagonal().toDenseMatrix(), false};
}

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
