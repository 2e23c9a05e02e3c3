#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <span>
#include <vector>

#include "core/arrays.h"
#include "forward/border/contact_electrodes.h"
#include "forward/ellipses/row_lu.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The equation of BorderModel specialised for fits, which try thousands of scenes: a few disjoint
/// ellipses inside the sheet. Voltages and exact derivatives with respect to all parameters take
/// tens of microseconds: smooth borders need few points, one factorisation serves both, and nothing
/// is allocated once a workspace has grown.
///
/// Points are at equal parameters. Where a border comes close to the sheet's or to another one they
/// are concentrated by a Moebius map exp(it) -> Moebius(exp(is)), with which the rule stays
/// spectral. At `most_points` the accuracy is limited: next to the sheet's border the voltages are
/// then accurate to a few per cent of the contact's own, which a fit tolerates.
///
/// All functions are const and thread-safe; a workspace serves one thread.
class EllipseModel {
 public:
  static constexpr int least_points = 8;  ///< on one border

  struct Options {
    double resolution = 1.4;  ///< 1: spacing of points as large as the distance to the neighbour
    int most_points = 40;     ///< on one border
  };

  class Workspace;

  explicit EllipseModel(const Sensor& sensor);
  EllipseModel(const Sensor& sensor, const Options& options);

  const Sensor& sensor() const { return sensor_; }
  Eigen::Index pairs() const { return static_cast<Eigen::Index>(pairs_.size()); }

  /// Places the points of these contacts. Returns false unless all are inside the sheet and
  /// disjoint.
  bool place(std::span<const EllipticContact> contacts, Workspace& workspace) const;
  /// `change` [pairs] V of the contacts placed last: mean change of the two channels of each of
  /// reciprocal_pairs().
  void evaluate(Workspace& workspace, Eigen::Ref<Eigen::VectorXd> change) const;
  /// `out` [pairs, EllipticContact::parameters * contacts] V per unit: derivatives at the contacts
  /// evaluated last. May be called once after each evaluation.
  void derivatives(Workspace& workspace, Eigen::Ref<Eigen::MatrixXd> out) const;

 private:
  void assemble(Workspace& m) const;
  void place_sources(Workspace& m) const;
  void add_conductors(Workspace& m) const;

  Sensor sensor_;
  Options options_;
  DiscElectrodes nodes_;
  int stride_ = 0;                         ///< pairs of electrodes, rounded up to whole vectors
  std::vector<double> x_, y_;              ///< [nodes] on the unit circle
  std::vector<std::array<int, 2>> pairs_;  ///< measurement and drive of each reciprocal pair
  std::vector<double> volts_;              ///< [pairs] I/c0, V
  std::vector<Eigen::MatrixXd> differentiation_;           ///< d/dt at n equal parameters, by n
  std::vector<std::vector<std::complex<double>>> halves_;  ///< exp(i pi k / n), by n
};

/// Working memory of one thread: the intermediate results of EllipseModel.
class EllipseModel::Workspace {
 public:
  /// Unknowns of the last evaluation.
  int points() const { return unknowns; }

 private:
  friend class EllipseModel;
  struct Border {
    Eigen::Matrix2d to_unit;  ///< maps the ellipse onto the unit disc
    double shorter = 0;       ///< half axis
    int first = 0;
    int count = 0;
    double ratio = 1;
  };
  std::vector<Border> borders;
  int unknowns = 0;
  std::vector<EllipticContact> contacts;  ///< the contacts that were placed
  // For each point: position, normal and weight on the unit disc; the tangent on the sheet times
  // the step of the parameter, and the position relative to the contact's centre.
  std::vector<double> x, y, normal_x, normal_y, curvature, weight, depth;
  std::vector<std::complex<double>> tangent, from_centre;
  RowLu matrix;
  std::vector<double> density;    ///< [points, stride] for each drive
  std::vector<double> potential;  ///< [points, stride] of the points' charges at measuring pairs
  RowMajorMatrix slopes;          ///< [points, nodes] of unit charges at the electrodes' nodes
  RowMajorMatrix charges;  ///< [points, nodes] potentials of the points' charges at the nodes
  RowMajorMatrix by_electrode;
  std::vector<double> solution;  ///< [points, stride] of the transposed equation
  std::vector<double> along;     ///< [points, stride] slope of the potential along the border
  std::vector<double> gains;     ///< [strains, points] of a border, see EllipseModel::derivatives
  std::vector<double> products;  ///< [strains, stride, stride]
  Eigen::MatrixXd impedance;

  void resize(int count, int stride) {
    unknowns = count;
    matrix.resize(count);
    const auto n = static_cast<std::size_t>(count);
    if (x.size() < n) {
      for (auto* array : {&x, &y, &normal_x, &normal_y, &curvature, &weight, &depth}) {
        array->resize(n);
      }
      tangent.resize(n);
      from_centre.resize(n);
    }
    // A memory may have served a sensor of fewer pairs before.
    const std::size_t wide = n * static_cast<std::size_t>(stride);
    if (density.size() < wide) {
      for (auto* array : {&density, &potential, &solution, &along}) array->resize(wide);
    }
  }
};

/// The ellipse with a contact's centroid, area, aspect and axes of the second moments, and
/// conductivity. An ellipse is mapped to itself, a square to a disc.
EllipticContact nearest_ellipse(const Contact& contact);

}  // namespace ertbench
