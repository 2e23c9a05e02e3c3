#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "forward/border/border_layout.h"
#include "forward/border/contact_electrodes.h"

namespace ertbench {

/// Number of probes of a border, at equal parameters, before its points are chosen.
inline constexpr std::size_t gathering_probes = 16;

/// Concentration of the points of a closed border by a Moebius map exp(is) -> exp(it) of the unit
/// circle onto itself. Points are 1 / strength times as dense at the parameter `towards` as with
/// equal spacing, and thinner by the same factor on the far side. Functions smooth in t are smooth
/// in s.
struct Gathering {
  double strength = 1;
  double towards = 0;
  double count = 0;  ///< number of points needed
};

/// Position of the point for an equal parameter s, and dt/ds. Avoids angles, because it is
/// evaluated for hundreds of thousands of points.
struct Gathered {
  std::complex<double> turn;  ///< exp(i (t - towards))
  double slope;
};
/// `half` is exp(i (s - towards) / 2).
Gathered gathered(std::complex<double> half, const Gathering& gathering);

/// The gathering that needs the fewest points. `demand` is the number of equal points that would
/// suffice if the whole border were like each probe, `least` a lower limit.
Gathering gathering_for(const std::array<double, gathering_probes>& demand, double least);

/// d/ds at `count` equidistant points of a closed curve, s in [0, 1], of the trigonometric
/// polynomial through their values: [count, count].
Eigen::MatrixXd closed_differentiation(int count);

/// A region of low conductivity f at the sheet's border with the electrodes inside it. Their
/// charges, 1 / f for a unit current, make potentials of the order of 1 / f inside, which charges
/// on the region's border screen almost entirely. The small field outside would be a difference of
/// numbers of the order of 1 / f, with their errors. The screened part is therefore removed. With
/// the charges h that screen a unit charge at the electrode e, so that N_e - int N h is constant
/// outside,
///
///     u = N_e + int N phi ds + (1 / f - 1) (N_e - int N h ds), the last term only inside,
///     phi / (2 mu) - int d_n N phi ds = d_n N_e + (1 - f) / (r - l) h,
///
/// in which everything stays bounded as f goes to 0.
struct ScreenedRegion {
  std::vector<int> arcs;        ///< the region's border within the sheet, in one piece
  std::vector<int> electrodes;  ///< inside
  double ratio = 1;             ///< f
  Eigen::MatrixXd charges;      ///< [points, electrodes] h, 0 off the region's border
};

/// Regions of strong contacts that cover electrodes, without their charges. `source` [L] is the
/// background over the conductivity that each electrode touches. Regions that divide the rest of
/// the sheet are left out, because the potential outside need not be constant.
std::vector<ScreenedRegion> screened_regions(const Sheet& sheet, const BorderLayout& layout,
                                             const BorderPoints& points,
                                             const Eigen::Array2Xd& electrodes,
                                             const Eigen::ArrayXd& source);

/// The border integral equation (see BorderModel) at its quadrature points, for unit currents and a
/// sheet of conductivity 1: matrix * density = slopes'. The contribution of the densities to the
/// impedances is the pair differences of potentials * density.
struct BorderSystem {
  BorderPoints points;
  Eigen::ArrayXd left, right;  ///< [points] conductivity / background on either side
  Eigen::MatrixXd matrix;      ///< [points, points]
  /// Fields across the borders: [pairs, points] of unit currents through pairs or, where these are
  /// many and in the complete model, [nodes, points] of unit currents into nodes.
  Eigen::MatrixXd slopes;
  Eigen::MatrixXd potentials;  ///< [nodes, points] at the electrodes' nodes due to points' charges
  std::vector<ScreenedRegion> screened;
  /// [nodes] ratio of the charges to the potentials they make, to which the error of the
  /// discretisation is proportional.
  Eigen::ArrayXd magnitude;
};

/// `resolution` multiplies the layout's counts; `source` [nodes] is the background over the
/// conductivity that each node of the electrodes touches.
BorderSystem border_system(const Sheet& sheet, const BorderLayout& layout,
                           const DiscElectrodes& nodes, const Eigen::ArrayXd& source,
                           double resolution);

}  // namespace ertbench
