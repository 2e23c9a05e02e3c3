#pragma once

#include <Eigen/Core>
#include <cstdlib>
#include <memory>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

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

/// How a scene's voltages are computed; `automatic` takes whichever costs less for that scene.
/// Both are exact up to rounding.
enum class ForwardMethod { automatic, condensation, contact_update };

/// The finite-element model of the sheet: -div(sigma grad u) = 0 with point currents, linear
/// right triangles, one conductivity a pixel. On such a mesh the stiffness matrix is that of a
/// resistor grid. Equal to EIDORS's `d2s` to rounding.
///
/// Everything that the scene does not change is computed once, in the constructor; all functions
/// are const and thread-safe.
class ForwardModel {
 public:
  /// `grid`: pixels along the longer side, sensor.image_grid times a power of two.
  /// Throws InputError where the model does not serve (see fits_grid): where an electrode falls
  /// between nodes or has a width, or the sheet is not a square or rectangle in square pixels.
  ForwardModel(const Sensor& sensor, int grid);
  ~ForwardModel();
  ForwardModel(ForwardModel&&) noexcept;

  const Sensor& sensor() const;
  int grid() const;

  /// Voltages of the uniform sheet, [channels] V.
  const Eigen::VectorXd& reference_voltages() const;

  /// `conductivity` [scenes, pixels] S/m, all > 0, to voltages [scenes, channels] V.
  /// Each scene's result is the same whatever else is in the batch.
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
