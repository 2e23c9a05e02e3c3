#pragma once

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

/// Hyperparameters of PositionLikelihood.
struct LikelihoodScales {
  double width = 0.1;      ///< of the kernel, over the median squared distance of the positions
  double lambda = 0.1;     ///< ridge: variance of the noise over that of the frames
  double shrinkage = 0.5;  ///< of the noise's covariance to its diagonal, 0 ... 1
  double sharpness = 20;   ///< of the likelihood: half the number of independent channels
};

/// The position of a press by the likelihood of its frame. A kernel ridge regression predicts the
/// direction of the change that a press at each position x makes,
///
///     m(x) = mean + k(x, X) (K + lambda 1)^-1 (F - mean),
///
/// from two inputs instead of one for each channel, so that few presses suffice. F are changes
/// divided by their channel's rms and normalised. With the covariance C of the leave-one-out
/// residuals as the noise's, a frame f of unknown amplitude has the likelihood (1 - c(x)^2)^-s with
/// the cosine c between f and m(x) in the metric C^-1; the position is its mean over a grid.
class PositionLikelihood {
 public:
  /// `changes` [presses, channels], `positions` [presses, 2] domain units.
  PositionLikelihood(const RowMajorMatrix& changes, const Eigen::MatrixXd& positions,
                     const LikelihoodScales& scales);
  Eigen::Vector2d position(const Eigen::Ref<const Eigen::RowVectorXd>& change) const;

 private:
  Eigen::RowVectorXd channel_weights_;  ///< 1 / rms of the normalised changes; 0 where that is 0
  Eigen::MatrixXd whitening_;           ///< [channels, channels]
  Eigen::MatrixXd grid_;                ///< [points, 2] domain units
  Eigen::MatrixXd directions_;          ///< [points, channels] whitened predictions of length 1
  double sharpness_ = 1;
};

struct ChosenLikelihood {
  LikelihoodScales scales;
  double error = 0;  ///< mean distance in cross-validation, domain units
};

/// Chooses width and ridge by leave-one-out errors of the predicted frames, shrinkage and sharpness
/// by five-fold cross-validation of the position.
ChosenLikelihood choose_likelihood(const RowMajorMatrix& changes, const Eigen::MatrixXd& positions);

/// Mean position of the presses whose changes have the directions nearest to that of a frame.
class NearestPresses {
 public:
  NearestPresses(const RowMajorMatrix& changes, Eigen::MatrixXd positions, int count);
  Eigen::Vector2d position(const Eigen::Ref<const Eigen::RowVectorXd>& change) const;
  /// Mean leave-one-out error for each number of neighbours of 1, 2, 4, 8: the best and its error.
  static std::pair<int, double> choose(const RowMajorMatrix& changes,
                                       const Eigen::MatrixXd& positions);

 private:
  RowMajorMatrix directions_;
  Eigen::MatrixXd positions_;
  int count_;
};

}  // namespace ertbench
