#pragma once

#include <Eigen/Core>
#include <cstdlib>
#include <memory>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Green's function of the uniform sheet on its grid: the potential at node x for a unit current
/// into node y, G = K0^+ for conductivity 1.
///
/// The grid's Laplacian with insulated borders is the even reflection of the doubly periodic
/// lattice Laplacian with periods 2m and 2n, so that G is the sum of the lattice's Green's function
/// over the four mirror images of y. It is stored in a table of (2m + 1)(2n + 1) numbers. Sums of
/// sines in one direction have a closed form, so that the table costs one matrix product.
class LatticeGreen {
 public:
  LatticeGreen(int columns, int rows);  ///< pixels

  /// Potential (up to a constant) at node (row, column) for a unit current into node (row_source,
  /// column_source) that leaves uniformly over the sheet. Rows 0 ... rows, columns 0 ... columns.
  double operator()(int row, int column, int row_source, int column_source) const {
    const int dr = std::abs(row - row_source);
    const int dc = std::abs(column - column_source);
    const int sr = row + row_source;
    const int sc = column + column_source;
    return table_(dr, dc) + table_(dr, sc) + table_(sr, dc) + table_(sr, sc);
  }

 private:
  /// Periodic Green's function over distances 0 ... 2 rows, 0 ... 2 columns.
  Eigen::MatrixXd table_;
};

/// Method to compute a scene's voltages; `automatic` takes the cheaper one for the scene. Both are
/// exact up to rounding.
enum class ForwardMethod { automatic, condensation, contact_update };

/// Finite-element model of the sheet: -div(sigma grad u) = 0 with point currents, linear right
/// triangles and one conductivity per pixel. The stiffness matrix is that of a resistor grid. Equal
/// to EIDORS's `d2s` to rounding.
///
/// The constructor computes everything that does not depend on the scene; all functions are const
/// and thread-safe.
class ForwardModel {
 public:
  /// `grid`: pixels along the longer side, sensor.image_grid times a power of two.
  /// Throws InputError if the model does not apply (see fits_grid): an electrode falls between
  /// nodes or has a width, or the sheet is no square or rectangle in square pixels.
  ForwardModel(const Sensor& sensor, int grid);
  ~ForwardModel();
  ForwardModel(ForwardModel&&) noexcept;

  const Sensor& sensor() const;
  int grid() const;

  /// Voltages of the uniform sheet, [channels] V.
  const Eigen::VectorXd& reference_voltages() const;

  /// Voltages [scenes, channels] V for `conductivity` [scenes, pixels] S/m, all > 0. The result of
  /// a scene does not depend on the rest of the batch.
  Frames solve(const Eigen::Ref<const Images>& conductivity,
               ForwardMethod method = ForwardMethod::automatic) const;

  /// dV/dsigma [channels, pixels] in V per S/m, at the uniform background or at an image [pixels].
  RowMajorMatrix jacobian() const;
  RowMajorMatrix jacobian(const Eigen::VectorXd& conductivity) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace ertbench
