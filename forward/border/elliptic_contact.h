#pragma once

#include <Eigen/Core>
#include <span>

#include "forward/sheet/scene.h"

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

}  // namespace ertbench
