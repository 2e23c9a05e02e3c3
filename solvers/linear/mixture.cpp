#include "solvers/linear/mixture.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/linear/k_means.h"
#include "solvers/symmetric_eigen.h"

namespace ertbench {
namespace {

/// Directions of the changes that images are estimated from, and that tell the components apart. On
/// one to three contacts at 50 dB 64 and 24 have the least error of 40, 64, 104 and 16, 24, 32, 48,
/// 104: the rest is noise, of which covariances of few scenes know little.
constexpr Eigen::Index image_directions = 64;
constexpr Eigen::Index gate_directions = 24;
/// Scenes that the covariance within all components counts as beside a component's own.
constexpr double shared_scenes = 50;
/// Components less likely than this part of the likeliest have no share in an image.
constexpr double least_share = 1e-3;
constexpr double noise_part = 0.2;  ///< of the directions, the weakest, hold the noise alone

/// Eigenvectors of a symmetric matrix in descending order of their values, at most `count`.
Eigen::MatrixXd leading(const SymmetricEigen& eigen, Eigen::Index count) {
  const Eigen::Index size = std::min(count, eigen.vectors.cols());
  return eigen.vectors.rightCols(size).rowwise().reverse();
}

/// What k-means compares [scenes, directions + 1]: the shape of the change, and the logarithm of
/// its size, in which the noise counts for ten of its standard deviations.
Eigen::MatrixXf features(const TrainingScenes& scenes, const Eigen::MatrixXd& directions,
                         double noise) {
  constexpr double weight_of_shape = 1.5;
  Eigen::MatrixXf out(scenes.count(), directions.cols() + 1);
  Eigen::RowVectorXd change(scenes.pairs());
  for (Eigen::Index i = 0; i < scenes.count(); ++i) {
    scenes.change(i, change);
    const double size = change.norm() + 10 * noise;
    out.row(i).head(directions.cols()) =
        (weight_of_shape / size * (change * directions)).cast<float>();
    out(i, directions.cols()) = static_cast<float>(std::log(size / noise));
  }
  return out;
}

}  // namespace

Eigen::MatrixXd GaussianMixture::second_moment() const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(directions.rows(), directions.rows());
  for (const Component& c : components) {
    out += c.weight * (c.changes + c.change_mean * c.change_mean.transpose());
  }
  return out;
}

GaussianMixture fit_mixture(const TrainingScenes& scenes, int components) {
  const SymmetricEigen eigen = symmetric_eigen(moments_of(scenes, {}, true).changes);
  const auto weakest =
      static_cast<Eigen::Index>(std::ceil(noise_part * static_cast<double>(eigen.values.size())));
  const double largest = std::sqrt(eigen.values[eigen.values.size() - 1]);
  const double noise =
      std::max(std::sqrt(std::max(eigen.values.head(weakest).mean(), 0.0)), 1e-9 * largest);

  GaussianMixture out;
  out.directions = leading(eigen, image_directions);
  const std::vector<std::vector<Eigen::Index>> groups =
      k_means(features(scenes, leading(eigen, gate_directions), noise), components);
  Eigen::MatrixXd changes_within = Eigen::MatrixXd::Zero(scenes.pairs(), scenes.pairs());
  Eigen::MatrixXd cross_within = Eigen::MatrixXd::Zero(scenes.pixels(), out.directions.cols());
  for (const std::vector<Eigen::Index>& group : groups) {
    JointMoments moments = moments_of(scenes, group, false);
    const double weight = moments.scenes / static_cast<double>(scenes.count());
    out.components.push_back({weight, std::move(moments.change_mean), std::move(moments.image_mean),
                              std::move(moments.changes), moments.cross * out.directions});
    changes_within += weight * out.components.back().changes;
    cross_within += weight * out.components.back().cross;
  }
  for (GaussianMixture::Component& c : out.components) {
    const double own = c.weight * static_cast<double>(scenes.count());
    const double shared = shared_scenes / (own + shared_scenes);
    c.changes += shared * (changes_within - c.changes);
    c.cross += shared * (cross_within - c.cross);
  }
  return out;
}

MixtureMean::MixtureMean(const GaussianMixture& mixture, const std::vector<Eigen::Index>& kept,
                         double ridge) {
  const Eigen::MatrixXd whole = mixture.second_moment();
  const double noise = ridge * whole.diagonal().mean();
  // The same directions where all pairs are kept.
  const Eigen::MatrixXd directions =
      leading(symmetric_eigen(whole(kept, kept)), mixture.directions.cols());
  // What is known of x and a direction of all pairs, of the directions of those that are kept.
  const Eigen::MatrixXd overlap = mixture.directions(kept, Eigen::all).transpose() * directions;
  const Eigen::Index size = directions.cols();
  const Eigen::Index gate = std::min(gate_directions, size);
  const auto count = static_cast<Eigen::Index>(mixture.components.size());

  coordinates_ = Matrix::Zero(size, whole.rows());
  coordinates_(Eigen::all, kept) = (directions.transpose() / std::numbers::sqrt2).cast<float>();
  whitening_.resize(count * gate, gate);
  centres_.resize(count * gate);
  log_weight_.resize(count);
  estimates_.reserve(mixture.components.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const GaussianMixture::Component& c = mixture.components[static_cast<std::size_t>(k)];
    const Eigen::VectorXd mean = directions.transpose() * c.change_mean(kept);
    Eigen::MatrixXd covariance = directions.transpose() * c.changes(kept, kept) * directions;
    covariance.diagonal().array() += noise;
    const Eigen::LLT<Eigen::MatrixXd> all(covariance);
    const Eigen::MatrixXd solved = all.solve((c.cross * overlap).transpose());
    estimates_.push_back({solved.transpose().cast<float>(),
                          (c.image_mean - solved.transpose() * mean).cast<float>()});
    // The leading block of the inverse factor is that of the leading coordinates.
    const Eigen::MatrixXd inverse = all.matrixL().solve(Eigen::MatrixXd::Identity(size, size));
    whitening_.middleRows(k * gate, gate) = inverse.topLeftCorner(gate, gate).cast<float>();
    centres_.segment(k * gate, gate) =
        (inverse.topLeftCorner(gate, gate) * mean.head(gate)).cast<float>();
    log_weight_[k] = std::log(c.weight) + inverse.diagonal().head(gate).array().log().sum();
  }
}

void MixtureMean::estimate(const Eigen::Ref<const Eigen::VectorXd>& sums,
                           Eigen::Ref<Eigen::RowVectorXd> image) const {
  constexpr Eigen::Index most_pairs = 256;
  using Small = Eigen::Matrix<float, Eigen::Dynamic, 1, 0, most_pairs, 1>;
  thread_local Eigen::VectorXf whitened;
  thread_local Eigen::VectorXd score;
  thread_local Eigen::VectorXf out;
  thread_local Eigen::VectorXf in;

  in = sums.cast<float>();
  Small y(coordinates_.rows());
  y.noalias() = coordinates_ * in;
  const Eigen::Index gate = whitening_.cols();
  whitened.resize(whitening_.rows());
  whitened.noalias() = whitening_ * y.head(gate);
  whitened -= centres_;
  score.resize(log_weight_.size());
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    score[k] =
        log_weight_[k] - 0.5 * static_cast<double>(whitened.segment(k * gate, gate).squaredNorm());
  }
  score = (score.array() - score.maxCoeff()).exp();
  const double sum = (score.array() >= least_share).select(score.array(), 0).sum();
  out = Eigen::VectorXf::Zero(image.size());
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    if (score[k] < least_share) continue;
    const Estimate& estimate = estimates_[static_cast<std::size_t>(k)];
    const auto share = static_cast<float>(score[k] / sum);
    out += share * estimate.constant;
    y *= share;
    out.noalias() += estimate.matrix * y;
    y /= share;
  }
  image = out.transpose().cast<double>();
}

}  // namespace ertbench
