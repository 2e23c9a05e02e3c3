#pragma once

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

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
