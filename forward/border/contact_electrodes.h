#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// An ellipse of another conductivity by six numbers without bounds, in which nothing is singular:
/// not the disc, whose angle means nothing, and not the contact without contrast. Its border is
/// centre + exp(M) (cos t, sin t) with the symmetric matrix
///
///     M = [ log_size + stretch.x    stretch.y            ]
///         [ stretch.y               log_size - stretch.x ].
struct EllipticContact {
  static constexpr int parameters = 6;  ///< centre x, y, log_size, stretch x, y, log_ratio

  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< domain units
  double log_size = 0;                               ///< log of the geometric mean of the half axes
  Eigen::Vector2d stretch = Eigen::Vector2d::Zero();  ///< half the log of the aspect is its length
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

/// What the derivatives of a border model are by: for each contact its centre's x and y (per domain
/// unit), the growth of all its lengths about its centre, its rotation (per rad), the stretch of
/// its lengths along x against those along y, that along the diagonals x = y against x = -y (V per
/// 1), and the logarithm of its conductivity ratio.
struct ContactMotion {
  enum : int { x, y, growth, rotation, stretch, shear, log_ratio, count };
};

/// By ContactMotion to by EllipticContact's parameters: [ContactMotion::count, parameters], which
/// the derivatives are multiplied with from the right.
Eigen::Matrix<double, ContactMotion::count, EllipticContact::parameters> motion_of(
    const EllipticContact& contact);

/// The scene of these contacts.
Scene scene_of(std::span<const EllipticContact> contacts);

/// The electrodes as the border model sees them, taken to the unit disc: every one as one point
/// source, or with a width as a few at the Chebyshev nodes along it, where currents that are large
/// at an electrode's edges do no harm. All for unit current and a sheet of conductivity 1.
///
/// With N the Neumann function between the nodes and D the contact impedance over each node's share
/// of the width, the nodes' currents I and the electrodes' potentials U obey
///
///     (N + D) I = E U,   E^T I = J,
///
/// J the electrodes' currents, E [nodes, L] what node is whose (Cheng et al. 1989, Somersalo et al.
/// 1992). In the gap model I is spread evenly and U is the mean of the potential.
struct DiscElectrodes {
  /// `displacement` [L]: along the border, clockwise, domain units.
  DiscElectrodes(const Sensor& sensor, const Eigen::VectorXd& displacement);

  Eigen::Matrix2Xd positions;   ///< [2, nodes] on the sheet
  Eigen::Array2Xd places;       ///< [2, nodes] on the unit circle
  std::vector<int> electrodes;  ///< [nodes] whose node each is
  /// N between the nodes [nodes, nodes]; 0 on the diagonal of points, where it is never measured.
  Eigen::MatrixXd neumann;
  /// I by J on the uniform sheet, [nodes, L]; empty for points, whose currents are the electrodes'.
  Eigen::MatrixXd currents;
  Eigen::MatrixXd potentials;  ///< U by J on the uniform sheet, [L, L]
  /// Of the complete model alone, else empty: N + D, and R [nodes, modes] for the Neumann function
  /// of the sheet with its conductors, N(x, y) - (n(x)^T R) (R^T n(y)), n(x) that from x to the
  /// nodes.
  Eigen::MatrixXd with_contacts;
  Eigen::MatrixXd redistribution;

  std::vector<ElectrodePair> pairs;          ///< as in SensorPairs
  std::vector<std::array<int, 2>> channels;  ///< as in SensorPairs

  Eigen::Index nodes() const { return places.cols(); }
  bool is_complete() const { return with_contacts.size() > 0; }

  /// Rows by electrodes [L, n] to rows by pairs: the second's less the first's.
  Eigen::MatrixXd differences(const Eigen::MatrixXd& rows) const;
  /// Rows by nodes [nodes, n] to rows by pairs, the nodes' as `currents` shares them out.
  Eigen::MatrixXd pair_rows(const Eigen::MatrixXd& rows) const;
  /// Potentials [nodes, nodes] at nodes by unit currents of nodes, to [pairs, pairs].
  Eigen::MatrixXd pair_matrix(const Eigen::MatrixXd& by_nodes) const;
  /// Of the complete model: I by J, where a scene changes N by `change` [nodes, nodes].
  Eigen::MatrixXd currents_where(const Eigen::MatrixXd& change) const;
};

}  // namespace ertbench
