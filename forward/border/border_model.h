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

/// Voltages of the continuous sheet without a mesh, with unknowns on the borders of the contacts
/// only. With the Neumann function N of the sheet and the field u0 of the electrodes,
///
///     u = u0 + sum over the borders of  int N(x, y) phi(y) ds,
///
/// and the continuity of the current across a border between conductivities l (on its left) and r,
/// normal to the right, gives for the density phi
///
///     phi(x) / (2 mu) - sum int d_n(x) N(x, y) phi(y) ds = d_n u0(x),   mu = (r - l) / (r + l).
///
/// The electrodes may be points or have a width, with or without contact impedances
/// (DiscElectrodes). The change of the voltages is computed directly, not as a difference of large
/// numbers. Everything is computed on the unit disc (see Sheet::to_disc), where N takes two
/// logarithms. Every scene is possible: contacts with corners, contacts that overlap, cross the
/// sheet's border or cover electrodes.
///
/// All functions are const and thread-safe.
class BorderModel {
 public:
  explicit BorderModel(const Sensor& sensor);
  /// Displaces the electrodes clockwise along the border by `displacement` [L], domain units;
  /// `impedances` as for DiscElectrodes.
  BorderModel(const Sensor& sensor, const Eigen::VectorXd& displacement,
              const Eigen::VectorXd& impedances = {});

  const Sensor& sensor() const { return sensor_; }
  /// Voltages of the uniform sheet, [channels] V, in closed form.
  const Eigen::VectorXd& reference_voltages() const { return reference_; }

  struct Solution {
    Eigen::VectorXd change;  ///< [channels] V, from the reference voltages
    int points = 0;          ///< unknowns; 0 (and exact) if no border crosses the sheet
    double error = 0;        ///< estimated 2-norm of the error of `change`, V
  };

  /// Refines the resolution, with 1.5 times as many points each time, until the estimated error is
  /// at most `tolerance` V. If that takes more than `most_points`, returns the last solution, whose
  /// `error` is above the tolerance.
  ///
  /// The estimate is the larger of two independent ones: the deviation of the computed voltages
  /// from reciprocity, which only exact ones obey, and the change by the last refinement.
  Solution solve(const Scene& scene, double tolerance, int most_points = 1200) const;
  /// With a tolerance that depends on the change [channels] V itself.
  using Tolerance = std::function<double(const Eigen::VectorXd& change)>;
  Solution solve(const Scene& scene, const Tolerance& tolerance, int most_points = 1200) const;

  /// Solves one system. At `resolution` 1 the spacing of points is about the distance from a border
  /// to its nearest neighbour. The error is estimated from reciprocity only.
  Solution solve_at(const Scene& scene, double resolution) const;

  struct Linearisation {
    Eigen::VectorXd change;      ///< [channels] V, as from solve_at
    RowMajorMatrix derivatives;  ///< [channels, ContactMotion::count * contacts]
    int points = 0;              ///< unknowns
  };
  /// The change and its exact derivatives with respect to every contact's motions and ratio
  /// (ContactMotion), from the potentials and currents on the borders without another system.
  /// Throws InputError for contacts with corners, that cross the sheet's border or each other, or
  /// that cover an electrode.
  Linearisation linearise(const Scene& scene, double resolution) const;

 private:
  Eigen::VectorXd electrode_ratios(const Scene& scene) const;
  Solution solve_layout(const BorderLayout& layout, const Eigen::ArrayXd& source,
                        double resolution) const;
  /// Potentials [nodes, nodes] at the electrodes' nodes (rows) due to the charges of the unit
  /// currents themselves, beyond those on the uniform sheet; `potentials` as in BorderSystem.
  Eigen::MatrixXd source_potentials(const Eigen::ArrayXd& source,
                                    const std::vector<ScreenedRegion>& screened,
                                    const Eigen::MatrixXd& potentials) const;
  /// Change of the potentials between pairs [pairs, pairs] from the charges on the borders under
  /// unit currents, `density` [points, pairs or nodes], and from `own`, see source_potentials.
  Eigen::MatrixXd impedance_change(const BorderSystem& system, const Eigen::MatrixXd& own,
                                   const Eigen::MatrixXd& density) const;
  /// The system's matrix with the Neumann function of the sheet with its conductors
  /// (DiscElectrodes::redistribution), for contacts that cover no electrode: the slopes of the
  /// pairs' currents, spread as on the uniform sheet, then give the densities.
  Eigen::MatrixXd conductors_matrix(const BorderSystem& system) const;
  /// Change of the voltages as weighted means of reciprocal values, with the error estimate from
  /// their differences. `magnitude` as in BorderSystem: the value whose drive has the smaller
  /// charges is more accurate by their ratio.
  Solution reciprocal_mean(const Eigen::MatrixXd& impedance, const Eigen::ArrayXd& magnitude) const;
  /// Voltages [channels] V from `impedance` [measuring pairs, drive pairs] at conductivity 1.
  Eigen::VectorXd voltages(const Eigen::MatrixXd& impedance) const;

  Sensor sensor_;
  DiscElectrodes nodes_;
  std::vector<std::array<int, 2>> pairs_;  ///< reciprocal channels
  Eigen::VectorXd reference_;
};

/// Jacobian dV/dsigma [channels, pixels] of the uniform sheet in V per S/m, without a mesh:
///
///     dV(d, m)/dsigma_p = I / c0^2  int over pixel p of grad u_d . grad u_m,
///
/// where u is the field of a unit current on a sheet of conductivity 1, a sum of Neumann functions
/// of the electrodes (DiscElectrodes). The conformal map preserves the product of gradients. Gauss
/// points in boxes that are halved towards electrodes and towards the sheet's border integrate over
/// the part of the pixel on the sheet; pixels off it are zero.
RowMajorMatrix border_jacobian(const Sensor& sensor);

/// Densities of that integral at points of the sheet, [channels, places]: dV/dsigma per squared
/// domain unit.
Eigen::MatrixXd border_sensitivity(const Sensor& sensor,
                                   const std::vector<Eigen::Vector2d>& places);

}  // namespace ertbench
