#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/border/border_layout.h"
#include "forward/border/border_points.h"

namespace ertbench {

/// A region of low conductivity f at the sheet's border, with the electrodes that lie in it. Their
/// charges, 1 / f by unit current, make potentials of 1 / f inside, of which next to nothing comes
/// out: charges on the region's border screen them. Computed as it stands the little that does come
/// out is a difference of numbers of 1 / f, with their error. Therefore what is screened entirely
/// is taken out. With h the charges that screen a unit charge at the electrode e, so that N_e - int
/// N h is the same everywhere outside,
///
///     u = N_e + int N phi ds + (1 / f - 1) (N_e - int N h ds), the last term inside alone,
///     phi / (2 mu) - int d_n N phi ds = d_n N_e + (1 - f) / (r - l) h,
///
/// in which all stays bounded as f goes to 0.
struct ScreenedRegion {
  std::vector<int> arcs;        ///< the region's border within the sheet, in one piece
  std::vector<int> electrodes;  ///< inside
  double ratio = 1;             ///< f
  Eigen::MatrixXd charges;      ///< [points, electrodes] h, 0 off the region's border
};

/// The regions of strong contacts that cover electrodes, without their charges. `source` [L] is the
/// background over the conductivity that each electrode touches. A region that parts the rest of
/// the sheet is none of them: what lies outside need not have one potential.
std::vector<ScreenedRegion> screened_regions(const Sheet& sheet, const BorderLayout& layout,
                                             const BorderPoints& points,
                                             const Eigen::Array2Xd& electrodes,
                                             const Eigen::ArrayXd& source);

}  // namespace ertbench
