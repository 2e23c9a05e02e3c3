#pragma once

#include <Eigen/Core>
#include <algorithm>

namespace ertbench {

/// The value that `share` of the frames like these are above: the quantile of the generalised
/// Pareto tail that the farthest tenth of `values` (all >= 0) has by the moments of its logarithms
/// (Dekkers, Einmahl and de Haan, Ann. Statist. 17, 1989), be it heavy or bounded; and where the
/// tail has a lump, no less than the quantile of the values themselves. Some hundred values will
/// do.
double tail_limit(Eigen::VectorXd values, double share);

/// What is usual for a mean square q beside a signal whose square is s: q = a + b s, which covers
/// noise of a fixed level, noise of a fixed ratio to the signal, and what a model leaves of it.
struct UsualLevel {
  double a = 0;
  double b = 0;
  double limit = 0;  ///< of q / (a + b s)

  /// From the q and s of frames. `floor`: the least a, beside what a converter resolves.
  static UsualLevel of(const Eigen::VectorXd& q, const Eigen::VectorXd& s, double floor,
                       double share);
  double relative(double q, double s) const { return q / (a + b * s); }
};

/// The principal directions of frames that stand above the noise, and how they vary along them.
struct PrincipalDirections {
  static constexpr Eigen::Index most = 32;

  Eigen::VectorXd mean;           ///< [inputs]
  Eigen::MatrixXd rows;           ///< [directions, inputs], orthonormal
  Eigen::VectorXd inverse_power;  ///< [directions], one over the variances
  /// [directions]: of all linear functions of a frame the one whose mean is largest beside its
  /// scatter (Fisher's). Frames that are the negative of such as these have the wrong sign of it.
  Eigen::VectorXd tilt;

  /// `frames` [frames, inputs]; directions with at least twice the variance `noise`.
  static PrincipalDirections of(const Eigen::MatrixXd& frames, double noise);

  struct Place {
    double outside;   ///< the square of what the directions do not explain
    double distance;  ///< the square of the Mahalanobis distance within them
    double along;     ///< along `tilt`, from the mean's
  };
  /// `centred`: a frame less the mean.
  template <typename Vector>
  Place place(const Vector& centred) const {
    using Scores = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most, 1>;
    Scores scores;
    scores.noalias() = rows * centred;
    return {std::max(0.0, centred.squaredNorm() - scores.squaredNorm()),
            scores.cwiseAbs2().dot(inverse_power), scores.dot(tilt)};
  }
};

}  // namespace ertbench
