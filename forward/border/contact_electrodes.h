#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// An ellipse of another conductivity, in six unbounded parameters that are regular everywhere:
/// also at a disc, whose angle is undefined, and at a contact without contrast. Its border is
/// centre + exp(M) (cos t, sin t) with the symmetric matrix
///
///     M = [ log_size + stretch.x    stretch.y            ]
///         [ stretch.y               log_size - stretch.x ].
struct EllipticContact {
  static constexpr int parameters = 6;  ///< centre x, y, log_size, stretch x, y, log_ratio

  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< domain units
  double log_size = 0;                               ///< log of the geometric mean of the half axes
  Eigen::Vector2d stretch = Eigen::Vector2d::Zero();  ///< its norm is half the log of the aspect
  double log_ratio = 0;                               ///< log of the conductivity ratio

  using Vector = Eigen::Matrix<double, parameters, 1>;
  Vector vector() const;
  static EllipticContact from(const Eigen::Ref<const Vector>& vector);

  /// Half axes, the longer first, and the angle of the longer against x, rad.
  Eigen::Vector2d half_axes() const;
  double angle() const;
  double ratio() const;
  double area() const;
  /// As a contact of a scene, an ellipse.
  Contact contact() const;
};

/// Variables of the derivatives of a border model, for each contact: x and y of its centre (domain
/// units), relative growth about its centre, rotation (rad), stretch along x against y, shear along
/// the diagonals x = y against x = -y, and the logarithm of its conductivity ratio.
struct ContactMotion {
  enum : int { x, y, growth, rotation, stretch, shear, log_ratio, count };
};

/// Jacobian [ContactMotion::count, parameters] of ContactMotion with respect to EllipticContact's
/// parameters; multiply derivatives with it from the right.
Eigen::Matrix<double, ContactMotion::count, EllipticContact::parameters> motion_of(
    const EllipticContact& contact);

/// The scene of these contacts.
Scene scene_of(std::span<const EllipticContact> contacts);

/// Electrodes of the border model on the unit disc: each one point source or, with a width, several
/// at Chebyshev nodes along it, which suit the large currents at an electrode's edges. For unit
/// currents and a sheet of conductivity 1.
///
/// With the Neumann function N between the nodes and the contact impedance D over each node's share
/// of the width, the nodes' currents I and the electrodes' potentials U obey
///
///     (N + D) I = E U,   E^T I = J,
///
/// with the electrodes' currents J and the incidence E [nodes, L] of nodes and electrodes (Cheng et
/// al. 1989, Somersalo et al. 1992). In the gap model I is uniform and U is the mean potential.
struct DiscElectrodes {
  /// `displacement` [L]: along the border, clockwise, domain units. `impedances` [L]: relative to
  /// the sensor's contact impedance, of the complete model; empty: 1.
  DiscElectrodes(const Sensor& sensor, const Eigen::VectorXd& displacement,
                 const Eigen::VectorXd& impedances = {});

  Eigen::Matrix2Xd positions;   ///< [2, nodes] on the sheet
  Eigen::Array2Xd places;       ///< [2, nodes] on the unit circle
  std::vector<int> electrodes;  ///< [nodes] electrode of each node
  /// N between the nodes [nodes, nodes]; for points 0 on the diagonal, which is never measured.
  Eigen::MatrixXd neumann;
  /// I per J on the uniform sheet [nodes, L]; empty for points, where I = J.
  Eigen::MatrixXd currents;
  Eigen::MatrixXd potentials;  ///< U per J on the uniform sheet [L, L]
  /// For the complete model, else empty: N + D, and R [nodes, nodes] of the Neumann function of the
  /// sheet with its conductors, N(x, y) - n(x)^T R n(y), where n(x) is N from x to the nodes.
  Eigen::MatrixXd with_contacts;
  Eigen::MatrixXd redistribution;

  std::vector<ElectrodePair> pairs;          ///< as in SensorPairs
  std::vector<std::array<int, 2>> channels;  ///< as in SensorPairs
  std::vector<double> volts;                 ///< [channels] I/c0, V

  Eigen::Index nodes() const { return places.cols(); }
  bool is_complete() const { return with_contacts.size() > 0; }
  /// True if a system is solved for unit currents into nodes instead of through pairs.
  bool by_nodes() const { return is_complete() || std::ssize(pairs) > nodes(); }

  /// Rows by electrode [L, n] to rows by pair [pairs, n]: second less first.
  Eigen::MatrixXd differences(const Eigen::MatrixXd& rows) const;
  /// Rows by node [nodes, n] to rows by pair [pairs, n], with nodes weighted by `currents`.
  Eigen::MatrixXd pair_rows(const Eigen::MatrixXd& rows) const;
  /// Potentials at nodes for unit currents of nodes [nodes, nodes] to [pairs, pairs].
  Eigen::MatrixXd pair_matrix(const Eigen::MatrixXd& by_nodes) const;
  /// For the complete model: I per J if a scene changes N by `change` [nodes, nodes].
  Eigen::MatrixXd currents_where(const Eigen::MatrixXd& change) const;
};

}  // namespace ertbench
