#pragma once

#include <Eigen/Core>

#include "core/arrays.h"
#include "solvers/channel_mask.h"
#include "solvers/reciprocity.h"
#include "solvers/solver.h"
#include "solvers/total_variation/grid_laplacian.h"
#include "solvers/total_variation/pixel_edges.h"

namespace ertbench {

/// min over images x of P(x) = 1/2 |J x - d|^2 + alpha |A x|_1 on one sensor, J the Jacobian at the
/// uniform background, A the differences across the interior pixel edges times the edges' length.
///
/// Everything is kept in units in which |J| = 1, in the basis of J's left singular vectors:
/// channels then come in the order of what they tell, and small ones are neither lost beside large
/// ones nor worth the work where alpha is large.
class TotalVariation {
 public:
  explicit TotalVariation(const Sensor& sensor);
  /// The same problem without the channels of the `masked` electrodes.
  TotalVariation(const TotalVariation& whole, const Sensor& sensor, ElectrodeSet masked);

  const PixelEdges& edges() const { return edges_; }
  double edge_length() const { return edge_length_; }  ///< domain units

  Eigen::Index channels() const { return singular_values_.size(); }
  /// Largest singular value of J, V per S/m.
  double scale() const { return scale_; }
  /// Of J / scale(), descending.
  const Eigen::VectorXd& singular_values() const { return singular_values_; }
  /// (J / scale())^T [pixels, channels rounded up to GridLaplacian::block], zeros beyond.
  const RowMajorMatrix& jacobian_transposed() const { return jacobian_transposed_; }
  /// J 1 / scale(), the data of the constant image 1 [padded channels], and J^T of that [pixels].
  const Eigen::VectorXd& constant() const { return constant_; }
  const Eigen::VectorXd& constant_gradient() const { return constant_gradient_; }
  /// The factor of A^T A without the edges' length.
  const GridLaplacian& laplacian() const { return laplacian_; }

  /// A frame [channels of the sensor] in the basis above [padded channels], V.
  Eigen::VectorXd project(const Eigen::Ref<const Eigen::RowVectorXd>& frame) const;

 private:
  /// `right` [pixels, channels]: the right singular vectors; singular_values_ is set.
  void set_right(const Eigen::MatrixXd& right);

  Reciprocity reciprocity_;
  PixelEdges edges_;
  double edge_length_;
  GridLaplacian laplacian_;
  double scale_ = 1;
  Eigen::MatrixXd left_;   ///< [pairs, channels], zero in the rows of masked pairs
  Eigen::MatrixXd right_;  ///< [pixels, channels]
  Eigen::VectorXd singular_values_;
  RowMajorMatrix jacobian_transposed_;
  Eigen::VectorXd constant_;
  Eigen::VectorXd constant_gradient_;
};

}  // namespace ertbench
