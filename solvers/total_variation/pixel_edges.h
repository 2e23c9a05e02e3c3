#pragma once

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

/// Differences of an image [rows, columns] across its interior pixel edges: first those between
/// neighbours in a row, [rows, columns - 1], then those between neighbours in a column, [rows - 1,
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

}  // namespace ertbench
