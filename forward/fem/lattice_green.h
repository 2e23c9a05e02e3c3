#pragma once

#include <Eigen/Core>
#include <cstdlib>

namespace ertbench {

/// Green's function of the uniform sheet on its own grid: the potential at node x for a unit
/// current into node y, G = K0^+ for conductivity 1.
///
/// The grid's Laplacian with insulated borders is the even reflection of the doubly periodic
/// lattice Laplacian of periods 2m and 2n, so G is the sum of that lattice's Green's function over
/// the four mirror images of y. One table of (2m + 1)(2n + 1) numbers holds it; sums of sines along
/// one direction are known in closed form, so the table costs one matrix product.
class LatticeGreen {
 public:
  LatticeGreen(int columns, int rows);  ///< pixels

  /// Potential (up to a constant) at node (row, column) of the current 1 into node (row_source,
  /// column_source) that leaves evenly over the sheet. Rows run 0 ... rows, columns 0 ... columns.
  double operator()(int row, int column, int row_source, int column_source) const {
    const int dr = std::abs(row - row_source);
    const int dc = std::abs(column - column_source);
    const int sr = row + row_source;
    const int sc = column + column_source;
    return table_(dr, dc) + table_(dr, sc) + table_(sr, dc) + table_(sr, sc);
  }

 private:
  Eigen::MatrixXd
      table_;  ///< periodic Green's function over distances 0 ... 2 rows, 0 ... 2 columns
};

}  // namespace ertbench
