#include "solvers/linear/masked_inverse.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "solvers/channel_mask.h"
#include "solvers/decompositions.h"

namespace ertbench {
namespace {

/// In the order of Prior.
constexpr std::array<const char*, 3> prior_names = {"tikhonov", "noser", "laplace"};

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

}  // namespace

Prior prior_from_name(const std::string& name) {
  const auto found = std::find(prior_names.begin(), prior_names.end(), name);
  if (found == prior_names.end()) throw std::invalid_argument("no prior is called " + name);
  return static_cast<Prior>(found - prior_names.begin());
}

const char* name_of(Prior prior) { return prior_names[static_cast<std::size_t>(prior)]; }

PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns) {
  const Eigen::Index pixels = jacobian.cols();
  if (prior == Prior::tikhonov) return {Eigen::MatrixXd::Identity(pixels, pixels), false};
  if (prior == Prior::laplace) {
    return laplace_factors(columns, static_cast<int>(pixels) / columns);
  }
  // Pixels to which no channel is sensitive stay zero.
  const Eigen::VectorXd s = jacobian.colwise().norm().transpose();
  const double unseen = 1e-14 * s.maxCoeff();
  const Eigen::VectorXd shaping =
      s.unaryExpr([unseen](double v) { return v > unseen ? 1 / std::sqrt(v) : 0.0; });
  return {shaping.asDiagonal().toDenseMatrix(), false};
}

SpectralInverse::SpectralInverse(const Eigen::MatrixXd& jacobian, const PriorFactors& prior) {
  Eigen::MatrixXd shaped = jacobian * prior.shaping;
  if (prior.free_constant) {
    const Eigen::VectorXd k = jacobian.rowwise().sum();
    constant_ = k.transpose() / k.squaredNorm();
    shaped -= k * (constant_ * shaped);
  }
  const DenseSvd svd = dense_svd(shaped);
  // Orthogonal to k there is one direction less.
  const Eigen::Index kept =
      std::min(svd.values.size(), jacobian.rows() - (prior.free_constant ? 1 : 0));
  powers_ = svd.values.head(kept).cwiseAbs2();
  directions_ = svd.left.leftCols(kept);
  basis_ = prior.shaping * svd.right.leftCols(kept) * svd.values.head(kept).asDiagonal();
  if (prior.free_constant) basis_.rowwise() -= (constant_ * jacobian * basis_).eval();
}

SpectralInverse::SpectralInverse(const Eigen::MatrixXd& changes, const Eigen::MatrixXd& cross,
                                 double added)
    : noise_(added) {
  const SymmetricEigen eigen = symmetric_eigen(changes);
  powers_ = eigen.values.cwiseMax(0);
  directions_ = eigen.vectors;
  basis_ = cross * directions_;
}

void SpectralInverse::follow_noise() {
  constexpr double weakest = 0.25;  // of the directions, without a trace of scenes
  const auto count =
      static_cast<Eigen::Index>(std::ceil(weakest * static_cast<double>(powers_.size())));
  usual_ = powers_.head(count).mean();
  powers_ = (powers_.array() - usual_).max(0);
  noise_ += usual_;
}

Eigen::MatrixXd SpectralInverse::matrix() const {
  Eigen::MatrixXd out = basis_ * weights(noise_).asDiagonal() * directions_.transpose();
  if (constant_.size() > 0) out.rowwise() += constant_;
  return out;
}

Eigen::VectorXd SpectralInverse::image(Eigen::VectorXd means, const std::vector<Eigen::Index>& lost,
                                       double noise) const {
  constexpr double least = 0.01;  // of the usual noise
  const double ratio = usual_ > 0 && noise > 0 ? std::max(noise / usual_, least) : 1;
  const double variance = ratio * noise_;
  const Eigen::VectorXd weights = this->weights(variance);
  if (std::ssize(lost) == means.size()) return Eigen::VectorXd::Zero(basis_.rows());
  means(lost).setZero();
  const bool complete = directions_.cols() == directions_.rows();
  if (!lost.empty() && (!complete || 2 * std::ssize(lost) > means.size())) {
    return image_of_live(means, others(lost, means.size()), variance);
  }
  Eigen::VectorXd scores = directions_.transpose() * means;
  if (!lost.empty()) {
    const Eigen::MatrixXd rows = directions_(lost, Eigen::all);
    const Eigen::MatrixXd weighted = rows * weights.asDiagonal();
    const Eigen::VectorXd values =
        -(weighted * rows.transpose()).eval().llt().solve(weighted * scores);
    scores.noalias() += rows.transpose() * values;
    means(lost) = values;
  }
  Eigen::VectorXd image = basis_ * weights.cwiseProduct(scores);
  if (constant_.size() > 0) image.array() += constant_.dot(means);
  return image;
}

Eigen::VectorXd SpectralInverse::image_of_live(const Eigen::VectorXd& means,
                                               const std::vector<Eigen::Index>& live,
                                               double variance) const {
  const Eigen::MatrixXd rows = directions_(live, Eigen::all);
  Eigen::MatrixXd matrix = rows * powers_.asDiagonal() * rows.transpose();
  matrix.diagonal().array() += variance;
  const auto factor = matrix.llt();
  Eigen::VectorXd solved = factor.solve(means(live));
  double constant = 0;
  if (constant_.size() > 0) {
    const Eigen::VectorXd k = constant_(live).transpose() / constant_.squaredNorm();
    const Eigen::VectorXd of_constant = factor.solve(k);
    constant = k.dot(solved) / k.dot(of_constant);
    solved -= constant * of_constant;
  }
  return (basis_ * (rows.transpose() * solved)).array() + constant;
}

MaskedTsvd::MaskedTsvd(const Eigen::MatrixXd& jacobian, double least)
    : basis_(jacobian.transpose()), gram_(jacobian * jacobian.transpose()), least_(least) {}

Eigen::VectorXd MaskedTsvd::image(Eigen::VectorXd means, const std::vector<Eigen::Index>& lost,
                                  double) const {
  constexpr std::size_t most = 16;
  const std::lock_guard lock(mutex_);
  if (weights_.size() == most && !weights_.contains(lost)) weights_.clear();
  const auto [found, is_new] = weights_.try_emplace(lost);
  if (is_new) found->second = weights(lost);
  return basis_ * (found->second * means);
}

Eigen::MatrixXd MaskedTsvd::weights(const std::vector<Eigen::Index>& lost) const {
  const std::vector<Eigen::Index> kept = others(lost, gram_.rows());
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

}  // namespace ertbench
