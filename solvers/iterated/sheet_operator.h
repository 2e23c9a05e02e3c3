#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "solvers/total_variation/grid_laplacian.h"
#include "solvers/total_variation/pixel_edges.h"

namespace ertbench {

/// Voltages and Jacobian of the grid model (ForwardModel on the image's grid), halved by
/// reciprocity (Reciprocity), for one conductivity after another: a banded Cholesky factor L of the
/// stiffness, the voltages from L^-1 P, the Jacobian from the fields L^-T L^-1 P. Holds the working
/// memory of one thread, and allocates nothing after its construction.
class SheetOperator {
 public:
  /// Throws InputError where an electrode falls between the grid's nodes. The sensor is one that
  /// the grid serves (fits_grid).
  explicit SheetOperator(const Sensor& sensor);

  Eigen::Index pixels() const { return Eigen::Index{columns_} * rows_; }
  Eigen::Index pairs() const { return static_cast<Eigen::Index>(drives_.size()); }

  /// `ratio` [pixels]: conductivity / background, > 0. All below is for the last one set.
  void set_conductivity(const Eigen::VectorXd& ratio);
  /// d' of the pairs `kept`: change from the uniform sheet, V. [kept]
  void changes(const std::vector<Eigen::Index>& kept, Eigen::VectorXd& out) const;
  /// Its derivatives by the ratios, V. [kept, pixels]; computes the fields.
  void jacobian(const std::vector<Eigen::Index>& kept, RowMajorMatrix& out);

 private:
  int columns_;
  int rows_;
  PixelEdges edges_;  ///< of the nodes
  double scale_;      ///< sqrt(2) I / c0, V; without the root for single channels
  std::vector<std::array<Eigen::Index, 2>> drives_;  ///< drive and measurement of each pair
  GridLaplacian stiffness_;
  Eigen::VectorXd weights_;                        ///< [edges of the nodes]
  RowMajorMatrix currents_;                        ///< P [nodes, pairs rounded up]
  RowMajorMatrix half_;                            ///< L^-1 P
  Eigen::MatrixXd products_;                       ///< P^T K^-1 P
  Eigen::MatrixXd uniform_;                        ///< the same of the uniform sheet
  RowMajorMatrix fields_;                          ///< [drives rounded up, nodes]
  RowMajorMatrix along_rows_, along_columns_;      ///< differences of the fields [drives, edges]
  RowMajorMatrix row_products_, column_products_;  ///< of two drives, on the grid of edges
};

}  // namespace ertbench
