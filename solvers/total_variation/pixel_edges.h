#pragma once

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

/// Differences of an image [n^2] across its interior pixel edges: first those between neighbours in
/// a row, [n, n - 1], then those between neighbours in a column, [n - 1, n].
class PixelEdges {
 public:
  explicit PixelEdges(int n) : n_(n) {}

  int grid() const { return n_; }
  Eigen::Index pixels() const { return Eigen::Index{n_} * n_; }
  Eigen::Index count() const { return 2 * across(); }
  /// Number of edges between neighbours in a row, as many as between neighbours in a column.
  Eigen::Index across() const { return Eigen::Index{n_} * (n_ - 1); }

  /// Next pixel less previous: [n^2] -> [count].
  void differences(const Eigen::VectorXd& image, Eigen::VectorXd& edges) const {
    const Eigen::Map<const RowMajorMatrix> x(image.data(), n_, n_);
    Eigen::Map<RowMajorMatrix> in_row(edges.data(), n_, n_ - 1);
    Eigen::Map<RowMajorMatrix> in_column(edges.data() + across(), n_ - 1, n_);
    in_row = x.rightCols(n_ - 1) - x.leftCols(n_ - 1);
    in_column = x.bottomRows(n_ - 1) - x.topRows(n_ - 1);
  }

  /// The transpose: [count] -> [n^2].
  void transposed(const Eigen::VectorXd& edges, Eigen::VectorXd& image) const {
    const Eigen::Map<const RowMajorMatrix> in_row(edges.data(), n_, n_ - 1);
    const Eigen::Map<const RowMajorMatrix> in_column(edges.data() + across(), n_ - 1, n_);
    Eigen::Map<RowMajorMatrix> x(image.data(), n_, n_);
    x.setZero();
    x.rightCols(n_ - 1) += in_row;
    x.leftCols(n_ - 1) -= in_row;
    x.bottomRows(n_ - 1) += in_column;
    x.topRows(n_ - 1) -= in_column;
  }

 private:
  int n_;
};

}  // namespace ertbench
