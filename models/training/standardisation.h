#pragma once

#include <torch/types.h>

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

class DatasetFile;

/// Input of networks: the drop of each channel, v0 - v, less its mean over the training set and
/// divided by its standard deviation.
struct Standardisation {
  Eigen::RowVectorXf mean;   ///< [channels] V
  Eigen::RowVectorXf scale;  ///< [channels] 1/V, one over the standard deviation
  /// Unit of the images of a network: y = (1 - sigma / background) / image. It is 1 if contacts
  /// lower the conductivity. If they raise it, the largest rise of the training set is at y = .9,
  /// because the paper's networks make positive images only.
  double image = 1;

  static Standardisation of(const DatasetFile& training);

  /// `changes` [frames, channels] V, v - v0 -> [frames, channels].
  torch::Tensor apply(const FramesView& changes) const;
  /// As above for one frame, into contiguous memory [channels].
  template <typename Change>
  void apply(const Eigen::MatrixBase<Change>& change, float* out) const {
    Eigen::Map<Eigen::RowVectorXf>(out, mean.size()) =
        (-change.template cast<float>() - mean).cwiseProduct(scale);
  }
};

/// Affine estimate of least mean squared error (linear MMSE) of vectors x from vectors v, learned
/// from examples of both: x^ = W v + b with
///
///     W = C_xv C_vv^-1,   b = mean(x) - W mean(v)
///
/// and the covariances C of the examples. For Gaussian x and noise it is the optimal estimate.
class LinearEstimate {
 public:
  LinearEstimate(Eigen::Index inputs, Eigen::Index outputs);

  /// `inputs` [examples, inputs], `outputs` [examples, outputs].
  void add(const RowMajorMatrix& inputs, const RowMajorMatrix& outputs);

  struct Affine {
    RowMajorMatrix weights;  ///< W [outputs, inputs]
    Eigen::VectorXd offset;  ///< b [outputs]
  };
  /// Adds a ridge of a millionth of the mean variance to C_vv, so that fewer examples than inputs
  /// suffice.
  Affine solve() const;

 private:
  double count_ = 0;
  Eigen::VectorXd input_sum_;
  Eigen::VectorXd output_sum_;
  Eigen::MatrixXd input_products_;  ///< sum of v v^T
  Eigen::MatrixXd cross_products_;  ///< sum of x v^T
};

}  // namespace ertbench
