#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/arrays.h"
#include "core/layers.h"
#include "forward/sheet/sensor.h"
#include "solvers/channel_mask.h"
#include "solvers/solver.h"

namespace ertbench {

/// Changes of the training set, reduced by reciprocity, and its images. With `symmetries` every
/// scene also appears transformed by each symmetry of the sensor.
class TrainingScenes {
 public:
  /// Reads the whole training set. Throws InputError if there is none (`place` names the setting
  /// that needs it), if it is of another sensor, or if it has no contact.
  TrainingScenes(const FitInput& input, const std::string& place, bool symmetries);

  Eigen::Index count() const { return changes_.rows() * static_cast<Eigen::Index>(turns_.size()); }
  Eigen::Index pairs() const { return changes_.cols(); }
  Eigen::Index pixels() const { return images_.cols(); }

  /// d' of scene `index` < count() [pairs], V, and its image [pixels], S/m.
  void change(Eigen::Index index, Eigen::Ref<Eigen::RowVectorXd> out) const;
  void image(Eigen::Index index, Eigen::Ref<Eigen::RowVectorXd> out) const;

 private:
  struct Turn {
    std::vector<Eigen::Index> pairs, pixels;  ///< turned[i] = original[from[i]]
  };

  RowMajorMatrix changes_;  ///< [scenes, pairs]
  /// [scenes, pixels]; in single precision, because they take most of the memory.
  FloatRows images_;
  std::vector<Turn> turns_;  ///< the identity first
};

/// First and second moments of changes d' and images x over a set of scenes.
struct JointMoments {
  double scenes = 0;
  Eigen::VectorXd change_mean;  ///< [pairs]
  Eigen::VectorXd image_mean;   ///< [pixels]
  Eigen::MatrixXd changes;      ///< E[(d' - mean) (d' - mean)^T] [pairs, pairs], with the noise
  Eigen::MatrixXd cross;        ///< E[(x - mean) (d' - mean)^T] [pixels, pairs]
};

/// Moments over the scenes `which`, or over all if it is empty; `about_zero` sets the means to
/// zero.
JointMoments moments_of(const TrainingScenes& scenes, const std::vector<Eigen::Index>& which,
                        bool about_zero);

/// Clusters the rows of `points` [points, features] into up to `groups` groups by a dozen rounds of
/// Lloyd's algorithm (k-means) from k-means++ centres. Rows ascend within a group, and no group is
/// empty: fewer come back if points coincide. Deterministic.
std::vector<std::vector<Eigen::Index>> k_means(const Eigen::MatrixXf& points, int groups);

/// A mixture of joint Gaussians of changes d' and images x, a model of the training scenes.
struct GaussianMixture {
  struct Component {
    double weight = 0;            ///< share of the training scenes
    Eigen::VectorXd change_mean;  ///< [pairs] V
    Eigen::VectorXd image_mean;   ///< [pixels] S/m
    Eigen::MatrixXd changes;      ///< covariance of d' [pairs, pairs]
    Eigen::MatrixXd cross;        ///< of x with directions^T d' [pixels, directions]
  };

  /// Leading principal directions of the changes [pairs, directions], from whose coordinates images
  /// are estimated. Beyond 64 directions the changes are noise.
  Eigen::MatrixXd directions;
  std::vector<Component> components;

  /// E[d' d'^T] over all components [pairs, pairs].
  Eigen::MatrixXd second_moment() const;
};

/// Fits a mixture of up to `components` by k-means over the shape of the changes (position of the
/// contacts) and their strength in units of the noise. Each covariance is shrunk towards the pooled
/// one, which counts as 50 scenes.
GaussianMixture fit_mixture(const TrainingScenes& scenes, int components);

/// Posterior mean of the image under a mixture: the components' linear estimates, weighted by their
/// posterior probabilities. For one set of pairs, in single precision; const and thread-safe.
class MixtureMean {
 public:
  /// Uses the pairs `kept`, ascending, at least one. `ridge` is relative to the mean square of
  /// all changes.
  MixtureMean(const GaussianMixture& mixture, const std::vector<Eigen::Index>& kept, double ridge);

  /// `sums` [pairs] V: d_a + d_b; `image` [pixels] S/m.
  void estimate(const Eigen::Ref<const Eigen::VectorXd>& sums,
                Eigen::Ref<Eigen::RowVectorXd> image) const;
  /// Adds the same to pair_layers.
  void add_layers(LayerList& list, const Reciprocity& reciprocity) const;

 private:
  using Matrix = Eigen::MatrixXf;

  struct Estimate {
    Matrix matrix;             ///< [pixels, directions]
    Eigen::VectorXf constant;  ///< [pixels]
  };

  Matrix coordinates_;          ///< [directions, pairs], acts on the sums
  FloatRows whitening_;         ///< of the leading directions, component by component
  Eigen::VectorXf centres_;     ///< whitened means, component by component
  Eigen::VectorXd log_weight_;  ///< [components], with the determinant
  std::vector<Estimate> estimates_;
};

}  // namespace ertbench
