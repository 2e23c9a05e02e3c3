#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/arrays.h"
#include "solvers/linear/training_scenes.h"

namespace ertbench {

/// A mixture of joint Gaussians of changes d' and images x: what the training scenes look like.
struct GaussianMixture {
  struct Component {
    double weight = 0;            ///< share of the training scenes
    Eigen::VectorXd change_mean;  ///< [pairs] V
    Eigen::VectorXd image_mean;   ///< [pixels] S/m
    Eigen::MatrixXd changes;      ///< covariance of d' [pairs, pairs]
    Eigen::MatrixXd cross;        ///< of x with directions^T d' [pixels, directions]
  };

  /// Leading principal directions of all the changes [pairs, directions], in whose coordinates the
  /// images are estimated. Beyond 64 the changes are noise.
  Eigen::MatrixXd directions;
  std::vector<Component> components;

  /// E[d' d'^T] over all components [pairs, pairs].
  Eigen::MatrixXd second_moment() const;
};

/// Fits a mixture of up to `components` by k-means: scenes are alike whose changes have a like
/// shape (place of the contacts) and a like strength, in units of the noise. Each covariance is
/// mixed with that within all components, which counts as 50 scenes.
GaussianMixture fit_mixture(const TrainingScenes& scenes, int components);

/// The posterior mean of the image under a mixture: of each component its linear estimate, weighted
/// by the component's posterior probability. For one set of pairs, in one precision; const and
/// thread-safe.
class MixtureMean {
 public:
  /// Uses the pairs `kept`, ascending, at least one. `ridge` as mmse_matrix has it, beside the mean
  /// square of all the changes.
  MixtureMean(const GaussianMixture& mixture, const std::vector<Eigen::Index>& kept, double ridge);

  /// `sums` [pairs]: d_a + d_b of every pair; `image` [pixels].
  void estimate(const Eigen::Ref<const Eigen::VectorXd>& sums,
                Eigen::Ref<Eigen::RowVectorXd> image) const;

 private:
  using Matrix = Eigen::MatrixXf;
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  struct Estimate {
    Matrix matrix;             ///< [pixels, directions]
    Eigen::VectorXf constant;  ///< [pixels]
  };

  Matrix coordinates_;          ///< [directions, pairs], acts on the sums
  Rows whitening_;              ///< of the leading directions, component by component
  Eigen::VectorXf centres_;     ///< whitened means, component by component
  Eigen::VectorXd log_weight_;  ///< [components], with the determinant
  std::vector<Estimate> estimates_;
};

}  // namespace ertbench
