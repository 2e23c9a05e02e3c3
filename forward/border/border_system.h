#pragma once

#include <Eigen/Core>

#include "forward/border/border_layout.h"
#include "forward/border/screened_regions.h"

namespace ertbench {

/// The border integral equation (see BorderModel) at its quadrature points, for unit currents and a
/// sheet of conductivity 1: matrix * density = slopes', and the densities' part of the impedances
/// is the pair differences of potentials * density.
struct BorderSystem {
  BorderPoints points;
  Eigen::ArrayXd left, right;  ///< [points] conductivity / background on either side
  Eigen::MatrixXd matrix;      ///< [points, points]
  Eigen::MatrixXd slopes;      ///< [L, points] of the drives' fields across the borders
  Eigen::MatrixXd potentials;  ///< [L, points] at the electrodes, of the points' charges
  std::vector<ScreenedRegion> screened;
  /// [L] how many times larger than the potentials the charges are that make them, which is what
  /// the discretisation's error grows with.
  Eigen::ArrayXd magnitude;
};

/// `resolution` multiplies the layout's counts; `electrodes` [2, L] on the unit circle, `source`
/// [L] the background over the conductivity that each touches.
BorderSystem border_system(const Sheet& sheet, const BorderLayout& layout,
                           const Eigen::Array2Xd& electrodes, const Eigen::ArrayXd& source,
                           double resolution);

/// Row k: row k + 1 less row k, the first less the last at the end: drives and measuring pairs.
Eigen::MatrixXd pair_differences(const Eigen::MatrixXd& rows);

}  // namespace ertbench
