#pragma once

#include <Eigen/Core>

#include "core/arrays.h"
#include "solvers/total_variation/pixel_edges.h"

namespace ertbench {

/// Banded Cholesky factor of H = A^T diag(weights) A, the Laplacian of the pixel grid with weighted
/// edges, with its last pixel held at zero (H maps constants to zero; what remains is definite).
///
/// What is left of such a matrix after each elimination is a weighted Laplacian again. It is kept
/// as that: weights between pixels and to the pixel held, all positive, of which the diagonal is
/// the sum. No number is ever subtracted, so every entry of the factor is accurate to a few
/// roundings however many decades the weights span (Grassmann, Taksar, Heyman 1985), and the
/// factorisation cannot fail while sums do not overflow.
class GridLaplacian {
 public:
  /// Right-hand sides are solved in blocks of this many.
  static constexpr Eigen::Index block = 16;

  explicit GridLaplacian(int grid) : GridLaplacian(grid, grid) {}
  GridLaplacian(int columns, int rows);

  /// `weights` [edges], > 0.
  void factor(const PixelEdges& edges, const Eigen::VectorXd& weights);

  Eigen::Index unknowns() const { return unknowns_; }  ///< pixels - 1

  /// L^-1 of the first `columns` columns of `right` [>= unknowns, >= columns], to the first
  /// unknowns() rows of `out` [., columns]; `columns` is a multiple of `block`.
  void half_solve(const RowMajorMatrix& right, Eigen::Index columns, RowMajorMatrix& out) const;
  /// L^-T of the first `columns` columns of `x` [>= unknowns, >= columns], in place; `columns` is a
  /// multiple of `block`.
  void half_solve_transposed(RowMajorMatrix& x, Eigen::Index columns) const;
  /// L^-1 x and L^-T x in place; `x` [>= unknowns].
  void half_solve(Eigen::VectorXd& x) const;
  void half_solve_transposed(Eigen::VectorXd& x) const;

 private:
  template <int known>
  void eliminate();

  double* row(Eigen::Index j) { return band_.data() + j * stride_; }
  const double* row(Eigen::Index j) const { return band_.data() + j * stride_; }

  Eigen::Index columns_;  ///< the width of the band
  Eigen::Index rows_;
  Eigen::Index unknowns_;
  Eigen::Index stride_;  ///< columns rounded up to whole SIMD registers, and one more of zeros
  /// Row j: -L(j + i, j) at i - 1, i = 1 ... columns. During the factorisation the weight between j
  /// and j + i.
  Eigen::VectorXd band_;
  Eigen::VectorXd inverse_diagonal_;  ///< 1 / L(j, j)
  Eigen::VectorXd ground_;            ///< weight to the pixel held
};

}  // namespace ertbench
