#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/sheet/symmetry.h"
#include "solvers/reciprocity.h"
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

}  // namespace ertbench
