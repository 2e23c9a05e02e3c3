#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <vector>

#include "forward/border/border_layout.h"
#include "forward/border/contact_electrodes.h"

namespace ertbench {

/// Points at which a border is looked at before its points are chosen, at equal parameters.
inline constexpr std::size_t gathering_probes = 16;

/// How the points of a closed border are drawn together by the map exp(is) -> exp(it) of the unit
/// circle onto itself, a Moebius map: they are 1 / strength times as dense at the parameter
/// `towards` as equal ones, and as much thinner on the far side. What is smooth in t is so in s.
struct Gathering {
  double strength = 1;
  double towards = 0;
  double count = 0;  ///< points that it takes
};

/// Where the point stands that belongs to an equal parameter s, and dt/ds. All without an angle:
/// points are taken by the hundred thousand.
struct Gathered {
  std::complex<double> turn;  ///< exp(i (t - towards))
  double slope;
};
/// `half` is exp(i (s - towards) / 2).
Gathered gathered(std::complex<double> half, const Gathering& gathering);

/// What takes the fewest points, `demand` being how many equal ones would do if all the border were
/// as at each probe, and `least` how many it takes anyway.
Gathering gathering_for(const std::array<double, gathering_probes>& demand, double least);

/// d/ds at `count` equidistant points of a closed curve, s in [0, 1], of the trigonometric
/// polynomial through their values: [count, count].
Eigen::MatrixXd closed_differentiation(int count);

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
