#pragma once

#include <Eigen/Core>

#include "core/arrays.h"
#include "solvers/channel_mask.h"
#include "solvers/solver.h"

namespace ertbench {

/// Differences of an image [rows, columns] across its interior pixel edges: first between
/// neighbours in a row [rows, columns - 1], then between neighbours in a column [rows - 1,
/// columns].
class PixelEdges {
 public:
  explicit PixelEdges(int n) : PixelEdges(n, n) {}
  PixelEdges(int columns, int rows) : columns_(columns), rows_(rows) {}

  int columns() const { return columns_; }
  int rows() const { return rows_; }
  Eigen::Index pixels() const { return Eigen::Index{columns_} * rows_; }
  Eigen::Index count() const { return across() + along(); }
  /// Number of edges between neighbours in a row.
  Eigen::Index across() const { return Eigen::Index{rows_} * (columns_ - 1); }
  /// Number of edges between neighbours in a column.
  Eigen::Index along() const { return Eigen::Index{columns_} * (rows_ - 1); }

  /// Next pixel less previous: [pixels] -> [count].
  void differences(const Eigen::VectorXd& image, Eigen::VectorXd& edges) const {
    const Eigen::Map<const RowMajorMatrix> x(image.data(), rows_, columns_);
    Eigen::Map<RowMajorMatrix> in_row(edges.data(), rows_, columns_ - 1);
    Eigen::Map<RowMajorMatrix> in_column(edges.data() + across(), rows_ - 1, columns_);
    in_row = x.rightCols(columns_ - 1) - x.leftCols(columns_ - 1);
    in_column = x.bottomRows(rows_ - 1) - x.topRows(rows_ - 1);
  }

  /// The transpose: [count] -> [pixels].
  void transposed(const Eigen::VectorXd& edges, Eigen::VectorXd& image) const {
    const Eigen::Map<const RowMajorMatrix> in_row(edges.data(), rows_, columns_ - 1);
    const Eigen::Map<const RowMajorMatrix> in_column(edges.data() + across(), rows_ - 1, columns_);
    Eigen::Map<RowMajorMatrix> x(image.data(), rows_, columns_);
    x.setZero();
    x.rightCols(columns_ - 1) += in_row;
    x.leftCols(columns_ - 1) -= in_row;
    x.bottomRows(rows_ - 1) += in_column;
    x.topRows(rows_ - 1) -= in_column;
  }

 private:
  int columns_;
  int rows_;
};

/// Banded Cholesky factor of H = A^T diag(weights) A, the Laplacian of the pixel grid with weighted
/// edges. H maps constants to zero; with its last pixel held at zero the rest is definite.
///
/// Every elimination leaves a weighted Laplacian. It is stored as positive weights between pixels
/// and to the held pixel, whose sum is the diagonal. Nothing is ever subtracted, so that every
/// entry of the factor is accurate to a few roundings however many decades the weights span
/// (Grassmann, Taksar, Heyman 1985), and the factorisation cannot fail unless sums overflow.
class GridLaplacian {
 public:
  /// Number of right-hand sides that are solved together.
  static constexpr Eigen::Index block = 16;
  /// The next multiple of that.
  static Eigen::Index padded(Eigen::Index columns) { return (columns + block - 1) / block * block; }

  explicit GridLaplacian(int grid) : GridLaplacian(grid, grid) {}
  GridLaplacian(int columns, int rows);

  /// `weights` [edges], > 0.
  void factor(const PixelEdges& edges, const Eigen::VectorXd& weights);

  Eigen::Index unknowns() const { return unknowns_; }  ///< pixels - 1

  /// Applies L^-1 to the first `columns` columns of `right` [>= unknowns, >= columns] and writes
  /// the first unknowns() rows of `out` [., columns]; `columns` is a multiple of `block`.
  void half_solve(const RowMajorMatrix& right, Eigen::Index columns, RowMajorMatrix& out) const;
  /// Applies L^-T to the first `columns` columns of `x` [>= unknowns, >= columns] in place;
  /// `columns` is a multiple of `block`.
  void half_solve_transposed(RowMajorMatrix& x, Eigen::Index columns) const;
  /// Apply L^-1 and L^-T in place; `x` [>= unknowns].
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
  Eigen::Index stride_;  ///< columns rounded up to SIMD registers, plus one register of zeros
  /// Row j: -L(j + i, j) at i - 1, i = 1 ... columns; during the factorisation the weight between
  /// pixels j and j + i.
  Eigen::VectorXd band_;
  Eigen::VectorXd inverse_diagonal_;  ///< 1 / L(j, j)
  Eigen::VectorXd ground_;            ///< weight to the held pixel
};

/// The problem min over images x of P(x) = 1/2 |J x - d|^2 + alpha |A x|_1 on one sensor, with the
/// Jacobian J at the uniform background and the differences A across interior pixel edges times the
/// edges' length.
///
/// Everything is in units in which |J| = 1, in the basis of J's left singular vectors. Channels are
/// then ordered by sensitivity: weak ones are not lost beside strong ones, and can be skipped if
/// alpha is large.
class TotalVariation {
 public:
  explicit TotalVariation(const Sensor& sensor);
  /// Restricts `whole` to the channels without the `masked` electrodes.
  TotalVariation(const TotalVariation& whole, const Sensor& sensor, ElectrodeSet masked);

  const PixelEdges& edges() const { return edges_; }
  double edge_length() const { return edge_length_; }  ///< domain units

  Eigen::Index channels() const { return singular_values_.size(); }
  /// Largest singular value of J, V per S/m.
  double scale() const { return scale_; }
  /// Singular values of J / scale(), descending.
  const Eigen::VectorXd& singular_values() const { return singular_values_; }
  /// (J / scale())^T [pixels, channels rounded up to GridLaplacian::block], zeros beyond.
  const RowMajorMatrix& jacobian_transposed() const { return jacobian_transposed_; }
  /// J 1 / scale() [padded channels], the data of the constant image 1, and J^T of that [pixels].
  const Eigen::VectorXd& constant() const { return constant_; }
  const Eigen::VectorXd& constant_gradient() const { return constant_gradient_; }
  /// The factor of A^T A without the edges' length.
  const GridLaplacian& laplacian() const { return laplacian_; }

  /// Transforms a frame [channels of the sensor] to the basis above [padded channels], V.
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
