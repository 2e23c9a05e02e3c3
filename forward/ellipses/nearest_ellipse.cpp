#include "forward/ellipses/nearest_ellipse.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "forward/sheet/cross.h"

namespace ertbench {
namespace {

using std::numbers::pi;

constexpr double thinnest = 1e-3;  ///< of a polygon's moments, the less over the greater

Eigen::Vector2d at_twice(double angle) { return {std::cos(2 * angle), std::sin(2 * angle)}; }

/// Centre, size and stretch of a polygon's.
EllipticContact of_polygon(const Contact& contact) {
  EllipticContact out;
  out.centre = contact.centroid();
  double area = 0;
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();  // about the centroid
  for (std::size_t i = 0; i < contact.vertices.size(); ++i) {
    const Eigen::Vector2d a = contact.vertices[i] - out.centre;
    const Eigen::Vector2d b = contact.vertices[(i + 1) % contact.vertices.size()] - out.centre;
    const double twice = cross(a, b);
    const Eigen::Vector2d sum = a + b;
    area += twice / 2;
    second += twice / 24 * (a * a.transpose() + b * b.transpose() + sum * sum.transpose());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(second / area);
  const Eigen::Vector2d longer = axes.eigenvectors().col(1);
  const double greater = axes.eigenvalues()[1];
  const double less = std::max(axes.eigenvalues()[0], thinnest * greater);
  out.log_size = std::log(std::abs(area) / pi) / 2;
  // The moments are as the squares of the half axes.
  out.stretch = std::log(greater / less) / 4 * at_twice(std::atan2(longer.y(), longer.x()));
  return out;
}

}  // namespace

EllipticContact nearest_ellipse(const Contact& contact) {
  EllipticContact out;
  if (contact.shape == Shape::polygon) {
    out = of_polygon(contact);
  } else {
    const double area = (contact.shape == Shape::rectangle ? 4 : pi) * contact.half_size.prod();
    out.centre = contact.centre;
    out.log_size = std::log(area / pi) / 2;
    out.stretch =
        std::log(contact.half_size.x() / contact.half_size.y()) / 2 * at_twice(contact.angle);
  }
  out.log_ratio = std::log(contact.conductivity_ratio);
  return out;
}

}  // namespace ertbench
