#include "forward/border/elliptic_contact.h"

#include <cmath>
#include <numbers>

namespace ertbench {

EllipticContact::Vector EllipticContact::vector() const {
  Vector out;
  out << centre, log_size, stretch, log_ratio;
  return out;
}

EllipticContact EllipticContact::from(const Eigen::Ref<const Vector>& vector) {
  return {vector.head<2>(), vector[2], vector.segment<2>(3), vector[5]};
}

Eigen::Vector2d EllipticContact::half_axes() const {
  const double half_log_aspect = stretch.norm();
  return {std::exp(log_size + half_log_aspect), std::exp(log_size - half_log_aspect)};
}

double EllipticContact::angle() const {
  // Of no direction where there is no stretch, which atan2 gives as 0.
  return std::atan2(stretch.y(), stretch.x()) / 2;
}

double EllipticContact::ratio() const { return std::exp(log_ratio); }

double EllipticContact::area() const { return std::numbers::pi * std::exp(2 * log_size); }

Contact EllipticContact::contact() const {
  Contact out;
  out.shape = Shape::ellipse;
  out.centre = centre;
  out.half_size = half_axes();
  out.angle = angle();
  out.conductivity_ratio = ratio();
  return out;
}

Eigen::Matrix<double, ContactMotion::count, EllipticContact::parameters> motion_of(
    const EllipticContact& contact) {
  Eigen::Matrix<double, ContactMotion::count, EllipticContact::parameters> out;
  out.setZero();
  out(ContactMotion::x, 0) = 1;
  out(ContactMotion::y, 1) = 1;
  out(ContactMotion::growth, 2) = 1;
  out(ContactMotion::log_ratio, 5) = 1;
  // In the axes of the ellipse, with half axes a, b and m = log(a / b) / 2: a change of M along the
  // axes strains the ellipse as it is; one across them, d, changes exp(M) by d (a - b) / (2 m) and
  // the ellipse as the strain d (a^2 - b^2) / (2 m (a^2 + b^2)) = d tanh(2 m) / (2 m) does.
  const double m = contact.stretch.norm();
  const double across = m > 1e-4 ? std::tanh(2 * m) / (2 * m) : 1 - 4 * m * m / 3;
  const Eigen::Vector2d axis = m > 0 ? Eigen::Vector2d(contact.stretch / m) : Eigen::Vector2d(1, 0);
  const Eigen::Vector2d other(-axis.y(), axis.x());
  out.block<2, 2>(ContactMotion::stretch, 3) =
      axis * axis.transpose() + across * other * other.transpose();
  return out;
}

Scene scene_of(std::span<const EllipticContact> contacts) {
  Scene scene;
  for (const EllipticContact& contact : contacts) scene.contacts.push_back(contact.contact());
  return scene;
}

}  // namespace ertbench
