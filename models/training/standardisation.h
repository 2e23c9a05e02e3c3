#pragma once

#include <torch/types.h>

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

class DatasetFile;

/// What networks are fed: the drop of each channel, v0 - v, less its mean over the training set and
/// divided by its standard deviation there.
struct Standardisation {
  Eigen::RowVectorXf mean;   ///< [channels] V
  Eigen::RowVectorXf scale;  ///< [channels] 1/V, one over the standard deviation
  /// What the images of a network are in: y = (1 - sigma / background) / image. 1 where contacts
  /// lower the conductivity; where they raise it, the largest rise of the training set is at y =
  /// .9, as the paper's networks know falls alone.
  double image = 1;

  static Standardisation of(const DatasetFile& training);

  /// `changes` [frames, channels] V, v - v0 -> [frames, channels].
  torch::Tensor apply(const FramesView& changes) const;
  /// The same for one frame, into contiguous memory [channels].
  template <typename Change>
  void apply(const Eigen::MatrixBase<Change>& change, float* out) const {
    Eigen::Map<Eigen::RowVectorXf>(out, mean.size()) =
        (-change.template cast<float>() - mean).cwiseProduct(scale);
  }
};

/// The affine estimate of least mean squared error (linear MMSE) of vectors x from vectors v, from
/// examples of both: x^ = W v + b with
///
///     W = C_xv C_vv^-1,   b = mean(x) - W mean(v)
///
/// and the examples' own covariances C. For Gaussian x and noise it is the best of all estimates.
class LinearEstimate {
 public:
  LinearEstimate(Eigen::Index inputs, Eigen::Index outputs);

  /// `inputs` [examples, inputs], `outputs` [examples, outputs].
  void add(const RowMajorMatrix& inputs, const RowMajorMatrix& outputs);

  struct Affine {
    RowMajorMatrix weights;  ///< W [outputs, inputs]
    Eigen::VectorXd offset;  ///< b [outputs]
  };
  /// A ridge of a millionth of the mean variance is put on C_vv, so that fewer examples than inputs
  /// give an estimate, too.
  Affine solve() const;

 private:
  double count_ = 0;
  Eigen::VectorXd input_sum_;
  Eigen::VectorXd output_sum_;
  Eigen::MatrixXd input_products_;  ///< sum of v v^T
  Eigen::MatrixXd cross_products_;  ///< sum of x v^T
};

}  // namespace ertbench
