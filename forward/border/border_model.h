#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <vector>

#include "core/arrays.h"
#include "forward/border/contact_electrodes.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

struct BorderLayout;
struct BorderSystem;
struct ScreenedRegion;

/// The voltages of the continuous sheet, without a mesh: unknowns on the borders of the contacts
/// alone. With N the Neumann function of the sheet and u0 the field of the electrodes,
///
///     u = u0 + sum over the borders of  int N(x, y) phi(y) ds,
///
/// and the continuity of the current across a border between conductivities l (on its left) and r,
/// normal to the right, gives for the density phi
///
///     phi(x) / (2 mu) - sum int d_n(x) N(x, y) phi(y) ds = d_n u0(x),   mu = (r - l) / (r + l).
///
/// The electrodes may be points or have a width, with or without contact impedances
/// (DiscElectrodes). The change of the voltages comes out directly, without a difference of large
/// numbers. All is computed on the unit disc (see Sheet::to_disc), where N takes two logarithms.
/// Every scene will do: contacts with corners, contacts that overlap, that the sheet's border cuts,
/// that cover electrodes.
///
/// All functions are const and thread-safe.
class BorderModel {
 public:
  explicit BorderModel(const Sensor& sensor);
  /// With every electrode moved along the border, clockwise: `displacement` [L], domain units.
  BorderModel(const Sensor& sensor, const Eigen::VectorXd& displacement);

  const Sensor& sensor() const { return sensor_; }
  /// Voltages of the uniform sheet, [channels] V: a closed formula.
  const Eigen::VectorXd& reference_voltages() const { return reference_; }

  struct Solution {
    Eigen::VectorXd change;  ///< [channels] V, from the reference voltages
    int points = 0;          ///< unknowns; 0 where no border crosses the sheet, which is exact
    double error = 0;        ///< estimated 2-norm of the error of `change`, V
  };

  /// The first of a ladder of resolutions, each with half as many points again, whose estimated
  /// error is at most `tolerance` V. Where that takes more than `most_points` the last solution
  /// comes back, its `error` above the tolerance.
  ///
  /// Two independent signs make the estimate, and the larger counts: how far the computed voltages
  /// are from reciprocity, which only the exact ones obey, and what the last refinement changed.
  Solution solve(const Scene& scene, double tolerance, int most_points = 1200) const;
  /// With a tolerance that depends on the change [channels] V itself.
  using Tolerance = std::function<double(const Eigen::VectorXd& change)>;
  Solution solve(const Scene& scene, const Tolerance& tolerance, int most_points = 1200) const;

  /// One system. At `resolution` 1 points are about as far apart as a border is from whatever is
  /// next to it. The estimate is the one from reciprocity alone.
  Solution solve_at(const Scene& scene, double resolution) const;

  struct Linearisation {
    Eigen::VectorXd change;      ///< [channels] V, as solve_at has it
    RowMajorMatrix derivatives;  ///< [channels, ContactMotion::count * contacts]
    int points = 0;              ///< unknowns
  };
  /// The change and its exact derivatives by every contact's motions and ratio (ContactMotion),
  /// from the potentials and currents on the borders and no further system. Throws InputError for
  /// contacts with corners, cut by the sheet's border or by one another, or on an electrode.
  Linearisation linearise(const Scene& scene, double resolution) const;

 private:
  Eigen::VectorXd electrode_ratios(const Scene& scene) const;
  Solution solve_layout(const BorderLayout& layout, const Eigen::ArrayXd& source,
                        double resolution) const;
  /// Potentials [nodes, nodes] at the electrodes' nodes (rows) by the unit currents' own charges,
  /// beyond those on the uniform sheet; `potentials` as in BorderSystem.
  Eigen::MatrixXd source_potentials(const Eigen::ArrayXd& source,
                                    const std::vector<ScreenedRegion>& screened,
                                    const Eigen::MatrixXd& potentials) const;
  /// The change of the potentials between pairs, [pairs, pairs], of what the borders' charges
  /// make of unit currents, `density` [points, pairs or nodes], and `own` as source_potentials.
  Eigen::MatrixXd impedance_change(const BorderSystem& system, const Eigen::MatrixXd& own,
                                   const Eigen::MatrixXd& density) const;
  /// The change of the voltages: weighted means of what reciprocity makes equal, and the estimate
  /// of the error that their differences give. `magnitude` as in BorderSystem: of two the one whose
  /// drive's charges are smaller is the better by as much.
  Solution reciprocal_mean(const Eigen::MatrixXd& impedance, const Eigen::ArrayXd& magnitude) const;
  /// `impedance` [pairs, pairs] by measuring and drive pair, conductivity 1, to [channels] V.
  Eigen::VectorXd voltages(const Eigen::MatrixXd& impedance) const;

  Sensor sensor_;
  DiscElectrodes nodes_;
  std::vector<std::array<int, 2>> pairs_;  ///< of channels that reciprocity makes equal
  Eigen::VectorXd reference_;
};

/// dV/dsigma [channels, pixels] in V per S/m of the uniform sheet, of the sensor's image, without a
/// mesh:
///
///     dV(d, m)/dsigma_p = I / c0^2  int over pixel p of grad u_d . grad u_m,
///
/// u by unit current on a sheet of conductivity 1, a sum of Neumann functions of the electrodes
/// (DiscElectrodes), whose product of gradients the conformal map keeps. By Gauss points, in boxes
/// that are halved towards electrodes and towards the sheet's border, over the part of the pixel
/// that is on the sheet; zero for pixels off it.
RowMajorMatrix border_jacobian(const Sensor& sensor);

/// The mean of a pixel's sensitivity is what the integral finds; this is the integral's density at
/// a place on the sheet: dV/dsigma per unit area (squared domain units), [channels].
Eigen::VectorXd border_sensitivity(const Sensor& sensor, const Eigen::Vector2d& place);

}  // namespace ertbench
