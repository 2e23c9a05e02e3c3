#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "solvers/total_variation/grid_laplacian.h"
#include "solvers/total_variation/total_variation.h"

namespace ertbench {

/// The system (H + J^T J) x = r of a Newton step, H = A^T diag(weights) A without the edges'
/// length, J of the leading singular values only.
///
/// With w = J x, and x = x0 + c 1 where the last pixel of x0 is zero: H x0 + J^T w = r, whose rows
/// add up to (J 1)^T w = 1^T r. So the band factor L of H gives G = L^-1 J^T, w and c follow from
/// S = I + G^T G, [channels, channels], and x0 from L. Neither H's being singular nor the decades
/// between its weights are felt.
class NewtonSystem {
 public:
  explicit NewtonSystem(const TotalVariation& problem);

  /// `weights` [edges] > 0. `channels` (a multiple of GridLaplacian::block) of J are used. False
  /// where rounding has made S indefinite.
  bool factor(const Eigen::VectorXd& weights, Eigen::Index channels);
  /// `right` and `x` [pixels].
  void solve(const Eigen::VectorXd& right, Eigen::VectorXd& x);

 private:
  double solve_data(Eigen::VectorXd& data, double sum) const;

  const TotalVariation& problem_;
  GridLaplacian band_;
  RowMajorMatrix half_;  ///< G [pixels - 1, channels]
  Eigen::MatrixXd schur_;
  Eigen::LLT<Eigen::MatrixXd> schur_factor_;
  Eigen::VectorXd constant_;        ///< J 1 [channels]
  Eigen::VectorXd constant_solve_;  ///< S^-1 J 1
  double constant_product_ = 0;     ///< (J 1)^T S^-1 J 1
  Eigen::VectorXd work_;            ///< [pixels - 1]
  Eigen::VectorXd data_;            ///< w [channels]
  Eigen::VectorXd error_;           ///< J x - w [channels]
};

}  // namespace ertbench
