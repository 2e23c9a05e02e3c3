#pragma once

#include <Eigen/Core>

#include "forward/border/border_layout.h"
#include "forward/border/disc_electrodes.h"
#include "forward/border/screened_regions.h"

namespace ertbench {

/// The border integral equation (see BorderModel) at its quadrature points, for unit currents and a
/// sheet of conductivity 1: matrix * density = slopes', and the densities' part of the impedances
/// is the pair differences of potentials * density.
struct BorderSystem {
  BorderPoints points;
  Eigen::ArrayXd left, right;  ///< [points] conductivity / background on either side
  Eigen::MatrixXd matrix;      ///< [points, points]
  /// Fields across the borders: [pairs, points] of currents by pairs, in the complete model [nodes,
  /// points] of unit currents of the nodes, which a scene shares out by itself.
  Eigen::MatrixXd slopes;
  Eigen::MatrixXd potentials;  ///< [nodes, points] at the electrodes' nodes, of the points' charges
  std::vector<ScreenedRegion> screened;
  /// [nodes] how many times larger than the potentials the charges are that make them, which is
  /// what the discretisation's error grows with.
  Eigen::ArrayXd magnitude;
};

/// `resolution` multiplies the layout's counts; `source` [nodes] is the background over the
/// conductivity that each node of the electrodes touches.
BorderSystem border_system(const Sheet& sheet, const BorderLayout& layout,
                           const DiscElectrodes& nodes, const Eigen::ArrayXd& source,
                           double resolution);

}  // namespace ertbench
