#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "core/arrays.h"
#include "solvers/solver.h"
#include "solvers/total_variation/total_variation.h"

namespace ertbench {

/// Adds G^T G, with G the first `rows` rows of `tall` [>= rows, columns], to the lower triangle of
/// `sum` [columns, columns]; `columns` is a multiple of 8. Also writes above the diagonal within
/// blocks of eight columns.
///
/// For matrices of some hundred rows and a hundred columns. Eigen's product copies its factors
/// first, which for these sizes takes a third of the time of the sums.
void add_gram(const RowMajorMatrix& tall, Eigen::Index rows, Eigen::MatrixXd& sum);

/// Solves the system (H + J^T J) x = r of a Newton step, with H = A^T diag(weights) A without the
/// edges' length and J restricted to the leading singular values.
///
/// Let w = J x and x = x0 + c 1, where the last pixel of x0 is zero. Then H x0 + J^T w = r, whose
/// rows add up to (J 1)^T w = 1^T r. The band factor L of H gives G = L^-1 J^T; w and c follow from
/// S = I + G^T G [channels, channels], and x0 from L. The result is accurate although H is singular
/// and its weights span decades.
class NewtonSystem {
 public:
  explicit NewtonSystem(const TotalVariation& problem);

  /// `weights` [edges] > 0. Uses the first `channels` of J, a multiple of GridLaplacian::block.
  /// False if rounding has made S indefinite.
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

struct InteriorPointOptions {
  double alpha = 0;  ///< weight of the total variation, V^2 / (S/m x domain unit), > 0
  double tolerance = 1e-4;
  int max_iterations = 50;
};

/// A primal-dual interior point method for total variation. In units in which |J| = 1 and |d| = 1,
/// with t = A x and its dual variable y, |y| <= 1, the optimum is where
///
///     J^T (J x - d) + alpha A^T y = 0,   t = z+ - z-,   z+ (1 - y) = 0,   z- (1 + y) = 0
///
/// with z+-, 1 - y, 1 + y >= 0. The last two equations are relaxed to mu > 0, and mu is reduced to
/// zero by Mehrotra's predictor and corrector (SIAM J. Optim. 2, 1992) with up to `corrections` of
/// Gondzio's centrality corrections (Comput. Optim. Appl. 6, 1996). All use one factorisation of a
/// NewtonSystem with weights alpha / (z+/(1 - y) + z-/(1 + y)). The smoothed iteration of Chan,
/// Golub and Mulet, the basis of EIDORS's PDIPM, eliminates z+-; keeping them allows full steps
/// close to the kinks of |t|.
///
/// It stops on a rigorous bound. J x - d, without its part along J 1, is made dual feasible: y is
/// moved as little as makes J^T w + alpha A^T y = 0 hold, and both are scaled until |y| <= 1. Then
/// -1/2 |w|^2 - w^T d is a lower bound of the optimum. At the end the gap between the best image
/// and the best bound, relative to the objective (of the reduced data, see Reciprocity), is at most
/// `tolerance`. If the image explains the data to 1e-5, the gap is relative to 1e-10 |d|^2 / 2.
///
/// Holds the working memory of one thread; the result of a frame does not depend on earlier frames.
class InteriorPoint {
 public:
  explicit InteriorPoint(const TotalVariation& problem);

  /// `frame` [channels] V, `image` [pixels] S/m. A frame that is not finite gives a zero image and
  /// the status undefined.
  void minimise(const Eigen::Ref<const Eigen::RowVectorXd>& frame,
                const InteriorPointOptions& options, Eigen::Ref<Eigen::RowVectorXd> image,
                FrameReport& report);

 private:
  static constexpr int corrections = 3;

  struct Direction {
    Eigen::VectorXd x;
    Eigen::ArrayXd y, above, below;
  };

  void start();
  void update_gap();
  bool step(Eigen::Index channels);
  void solve(const Eigen::ArrayXd& above_target, const Eigen::ArrayXd& below_target,
             Direction& direction);
  double longest(const Direction& direction) const;
  Eigen::Index useful_channels() const;

  const TotalVariation& problem_;
  NewtonSystem system_;
  Eigen::Index edges_;

  double alpha_ = 0;
  Eigen::VectorXd data_;  ///< d [channels]

  // The iterate: image [pixels], dual variable, z+ and z- [edges].
  Eigen::VectorXd x_, y_;
  Eigen::ArrayXd above_, below_;

  // Derived: A x, J x - d, J^T (J x - d), and the sum of the last with alpha A^T y.
  Eigen::VectorXd edge_, residual_, gradient_, dual_residual_;
  Eigen::ArrayXd above_slack_, below_slack_;  ///< 1 / (1 - y), 1 / (1 + y)
  Eigen::ArrayXd weight_;                     ///< [edges], without alpha

  Eigen::VectorXd best_x_, feasible_y_;
  double objective_ = 0;  ///< least so far
  double bound_ = 0;      ///< greatest so far
  double gap_ = 0;

  // Scratch.
  Eigen::VectorXd right_, pixel_, dual_step_, along_;
  Eigen::ArrayXd shift_, above_target_, below_target_, above_trial_, below_trial_;
  Direction direction_, corrected_;
};

}  // namespace ertbench
