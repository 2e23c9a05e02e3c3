#include "solvers/kernel/position_models.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "solvers/decompositions.h"
#include "solvers/kernel/kernel_regression.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int folds = 5;
constexpr int grid_side = 41;
constexpr double grid_margin = 1.03;  ///< the grid's radius over that of the presses

const std::vector<double> widths = {0.02, 0.05, 0.1, 0.2, 0.4, 0.8};
const std::vector<double> lambdas = {1e-3, 1e-2, 0.03, 0.1, 0.3, 1};
const std::vector<double> shrinkages = {0.3, 0.6, 0.9};
const std::vector<double> sharpnesses = {5, 10, 20, 40, 80, 160};

RowMajorMatrix normalised(RowMajorMatrix rows) {
  for (auto row : rows.rowwise()) {
    if (const double norm = row.norm(); norm > 0) row /= norm;
  }
  return rows;
}

RowVectorXd weights_of(const RowMajorMatrix& changes) {
  const RowVectorXd rms =
      (normalised(changes).colwise().squaredNorm() / double(changes.rows())).cwiseSqrt();
  const double least = 1e-9 * rms.maxCoeff();
  return rms.unaryExpr([&](double value) { return value > least ? 1 / value : 0; });
}

/// Points on a disc that covers the presses.
MatrixXd grid_over(const MatrixXd& positions) {
  const RowVectorXd middle = (positions.colwise().minCoeff() + positions.colwise().maxCoeff()) / 2;
  const double radius = grid_margin * (positions.rowwise() - middle).rowwise().norm().maxCoeff();
  MatrixXd out(grid_side * grid_side, 2);
  Index points = 0;
  for (int i = 0; i < grid_side * grid_side; ++i) {
    const Vector2d at(i % grid_side, i / grid_side);
    const Vector2d offset = radius * (2 * at.array() / (grid_side - 1) - 1).matrix();
    if (offset.norm() <= radius) out.row(points++) = middle + offset.transpose();
  }
  return out.topRows(points);
}

/// Predicted frames on the grid, and the covariance of the leave-one-out residuals.
struct Prediction {
  MatrixXd frames;
  MatrixXd covariance;
};

Prediction predict(const MatrixXd& features, const MatrixXd& positions, const MatrixXd& grid,
                   const LikelihoodScales& scales) {
  const MatrixXd squared = squared_distances(positions, positions);
  const double denominator = scales.width * median_distance(squared);
  MatrixXd kernel = radial_kernel(squared, denominator);
  kernel.diagonal().array() += scales.lambda;
  const MatrixXd inverse = kernel.llt().solve(MatrixXd::Identity(kernel.rows(), kernel.cols()));
  const RowVectorXd mean = features.colwise().mean();
  const MatrixXd coefficients = inverse * (features.rowwise() - mean);
  const MatrixXd residuals = coefficients.array().colwise() / inverse.diagonal().array();
  return {
      (radial_kernel(squared_distances(grid, positions), denominator) * coefficients).rowwise() +
          mean,
      residuals.transpose() * residuals / double(features.rows())};
}

MatrixXd whitening_of(const MatrixXd& covariance, double shrinkage) {
  MatrixXd shrunk = (1 - shrinkage) * covariance;
  shrunk.diagonal() += shrinkage * covariance.diagonal();
  shrunk.diagonal().array() += 1e-6 * covariance.trace() / double(covariance.rows()) + 1e-300;
  const SymmetricEigen eigen = symmetric_eigen(shrunk);
  return eigen.vectors * eigen.values.cwiseMax(1e-300).cwiseSqrt().cwiseInverse().asDiagonal();
}

/// Mean of the grid under the likelihood; `cosines` [points].
Vector2d mean_position(const VectorXd& cosines, double sharpness, const MatrixXd& grid) {
  const VectorXd log = -sharpness * (1 - cosines.array().square()).max(1e-12).log();
  const VectorXd weights = (log.array() - log.maxCoeff()).exp();
  return grid.transpose() * weights / weights.sum();
}

/// Width and ridge with the least leave-one-out residuals of the predicted frames.
LikelihoodScales choose_kernel(const MatrixXd& features, const MatrixXd& positions) {
  const MatrixXd squared = squared_distances(positions, positions);
  const double median = median_distance(squared);
  LikelihoodScales best;
  double least = std::numeric_limits<double>::infinity();
  for (const double width : widths) {
    const std::vector<MatrixXd> residuals =
        leave_one_out(radial_kernel(squared, width * median), features, lambdas);
    for (std::size_t l = 0; l < lambdas.size(); ++l) {
      const double error = residuals[l].squaredNorm();
      if (!(error < least)) continue;
      least = error;
      best.width = width;
      best.lambda = lambdas[l];
    }
  }
  return best;
}

}  // namespace

PositionLikelihood::PositionLikelihood(const RowMajorMatrix& changes, const MatrixXd& positions,
                                       const LikelihoodScales& scales)
    : channel_weights_(weights_of(changes)),
      grid_(grid_over(positions)),
      sharpness_(scales.sharpness) {
  const RowMajorMatrix features = normalised(changes * channel_weights_.asDiagonal());
  const Prediction prediction = predict(features, positions, grid_, scales);
  whitening_ = whitening_of(prediction.covariance, scales.shrinkage);
  directions_ = normalised(prediction.frames * whitening_);
}

Vector2d PositionLikelihood::position(const Eigen::Ref<const RowVectorXd>& change) const {
  const RowVectorXd frame = change.cwiseProduct(channel_weights_) * whitening_;
  return mean_position(directions_ * frame.normalized().transpose(), sharpness_, grid_);
}

ChosenLikelihood choose_likelihood(const RowMajorMatrix& changes, const MatrixXd& positions) {
  const MatrixXd features = normalised(changes * weights_of(changes).asDiagonal());
  const std::vector<Index> few = spread_rows(features.rows(), most_searched);
  const LikelihoodScales kernel =
      choose_kernel(features(few, Eigen::all), positions(few, Eigen::all));
  const MatrixXd grid = grid_over(positions);
  MatrixXd errors = MatrixXd::Zero(std::ssize(shrinkages), std::ssize(sharpnesses));
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<Index> learned, held;
    for (Index i = 0; i < features.rows(); ++i) (i % folds == fold ? held : learned).push_back(i);
    if (learned.size() < 2) continue;
    const Prediction prediction =
        predict(features(learned, Eigen::all), positions(learned, Eigen::all), grid, kernel);
    for (Index s = 0; s < errors.rows(); ++s) {
      const MatrixXd whitening =
          whitening_of(prediction.covariance, shrinkages[static_cast<std::size_t>(s)]);
      const MatrixXd cosines = normalised(prediction.frames * whitening) *
                               normalised(features(held, Eigen::all) * whitening).transpose();
      for (std::size_t i = 0; i < held.size(); ++i) {
        for (Index k = 0; k < errors.cols(); ++k) {
          const Vector2d found = mean_position(cosines.col(static_cast<Index>(i)),
                                               sharpnesses[static_cast<std::size_t>(k)], grid);
          errors(s, k) += (found.transpose() - positions.row(held[i])).norm();
        }
      }
    }
  }
  Index s = 0, k = 0;
  ChosenLikelihood best{kernel, errors.minCoeff(&s, &k) / double(features.rows())};
  best.scales.shrinkage = shrinkages[static_cast<std::size_t>(s)];
  best.scales.sharpness = sharpnesses[static_cast<std::size_t>(k)];
  return best;
}

NearestPresses::NearestPresses(const RowMajorMatrix& changes, MatrixXd positions, int count)
    : directions_(normalised(changes)), positions_(std::move(positions)), count_(count) {}

Vector2d NearestPresses::position(const Eigen::Ref<const RowVectorXd>& change) const {
  const VectorXd cosines = directions_ * change.normalized().transpose();
  std::vector<Index> order(static_cast<std::size_t>(cosines.size()));
  std::iota(order.begin(), order.end(), Index{0});
  const auto count = std::min<Index>(count_, cosines.size());
  std::partial_sort(order.begin(), order.begin() + count, order.end(),
                    [&](Index a, Index b) { return cosines[a] > cosines[b]; });
  order.resize(static_cast<std::size_t>(count));
  return positions_(order, Eigen::all).colwise().mean().transpose();
}

std::pair<int, double> NearestPresses::choose(const RowMajorMatrix& changes,
                                              const MatrixXd& positions) {
  const RowMajorMatrix directions = normalised(changes);
  MatrixXd cosines = directions * directions.transpose();
  cosines.diagonal().setConstant(-2);
  std::pair<int, double> best{1, std::numeric_limits<double>::infinity()};
  std::vector<Index> order(static_cast<std::size_t>(cosines.rows()));
  for (const int count : {1, 2, 4, 8}) {
    if (count >= cosines.rows()) break;
    double error = 0;
    for (Index i = 0; i < cosines.rows(); ++i) {
      std::iota(order.begin(), order.end(), Index{0});
      std::nth_element(order.begin(), order.begin() + count, order.end(),
                       [&](Index a, Index b) { return cosines(a, i) > cosines(b, i); });
      const std::vector<Index> near(order.begin(), order.begin() + count);
      error += (positions(near, Eigen::all).colwise().mean() - positions.row(i)).norm();
    }
    error /= double(cosines.rows());
    if (error < best.second) best = {count, error};
  }
  return best;
}

}  // namespace ertbench
