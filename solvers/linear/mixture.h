#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "solvers/channel_mask.h"
#include "solvers/solver.h"

namespace ertbench {

/// What an estimator learns from: the changes of the training set, halved by reciprocity, beside
/// its images, every scene as it is and, with `symmetries`, turned by each symmetry of the sensor.
class TrainingScenes {
 public:
  /// Reads the whole training set. Throws InputError where there is none (`place` is what needs
  /// it), where it is of another sensor, or where it has no contact.
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
  /// [scenes, pixels]; in single precision, for they are most of the memory.
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> images_;
  std::vector<Turn> turns_;  ///< the identity first
};

/// First and second moments of changes d' and images x over some scenes.
struct JointMoments {
  double scenes = 0;
  Eigen::VectorXd change_mean;  ///< [pairs]
  Eigen::VectorXd image_mean;   ///< [pixels]
  Eigen::MatrixXd changes;      ///< E[(d' - mean) (d' - mean)^T] [pairs, pairs], noise and all
  Eigen::MatrixXd cross;        ///< E[(x - mean) (d' - mean)^T] [pixels, pairs]
};

/// Of the scenes `which`, all of them where it is empty; `about_zero`: with means of zero.
JointMoments moments_of(const TrainingScenes& scenes, const std::vector<Eigen::Index>& which,
                        bool about_zero);

/// Divides the rows of `points` [points, features] into up to `groups` groups of rows that lie
/// close together, by Lloyd's algorithm (k-means) from centres drawn by k-means++, a dozen rounds
/// of it. Each group's rows ascend; none is empty, so that fewer groups come back where points
/// coincide. The same every time.
std::vector<std::vector<Eigen::Index>> k_means(const Eigen::MatrixXf& points, int groups);

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
