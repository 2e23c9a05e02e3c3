#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "forward/border/border_system.h"
#include "forward/ellipses/ellipse_model.h"
#include "forward/sheet/cross.h"

namespace ertbench {
namespace {

using std::numbers::pi;

constexpr double thinnest = 1e-3;  ///< of a polygon's moments, the less over the greater

Eigen::Vector2d at_twice(double angle) { return {std::cos(2 * angle), std::sin(2 * angle)}; }

/// Sets centre, size and stretch from the moments of a polygon.
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

using Complex = std::complex<double>;

/// Spacing of points over the distance to their nearest neighbour at resolution 1 (see
/// border_layout).
constexpr double spacing_over_distance = 0.8;
constexpr std::size_t most_contacts = 16;
/// Smaller distances to the sheet's border or to another contact are treated as this, domain units.
constexpr double closest = 1e-4;
/// Least contrast of a contact, so that 1 / (2 mu) stays finite.
constexpr double least_contrast = 1e-9;

const std::array<Complex, gathering_probes>& probes() {
  static const std::array<Complex, gathering_probes> table = [] {
    std::array<Complex, gathering_probes> out;
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      out[i] = std::polar(1.0, 2 * pi * static_cast<double>(i) / gathering_probes);
    }
    return out;
  }();
  return table;
}

/// As std::abs, for numbers whose squares do not overflow.
double length_of(Complex z) { return std::sqrt(std::norm(z)); }

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

bool EllipseModel::place(std::span<const EllipticContact> contacts, Workspace& m) const {
  const Sheet& sheet = *sensor_.sheet;
  if (contacts.size() > most_contacts) return false;
  struct Ellipse {
    Complex turn, centre;
    Eigen::Vector2d axes;
    Gathering gathering;
  };
  std::array<Ellipse, most_contacts> ellipses;
  m.borders.resize(contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const EllipticContact& contact = contacts[k];
    Ellipse& ellipse = ellipses[k];
    ellipse.axes = contact.half_axes();
    if (!std::isfinite(ellipse.axes.x()) || !contact.centre.allFinite()) return false;
    ellipse.turn = std::polar(1.0, contact.angle());
    ellipse.centre = {contact.centre.x(), contact.centre.y()};
    auto& border = m.borders[k];
    border.shorter = ellipse.axes.y();
    const double cos = ellipse.turn.real();
    const double sin = ellipse.turn.imag();
    border.to_unit << cos / ellipse.axes.x(), sin / ellipse.axes.x(), -sin / ellipse.axes.y(),
        cos / ellipse.axes.y();
    border.ratio = contact.ratio();
    if (std::abs(1 - border.ratio) < least_contrast) border.ratio = 1 - least_contrast;
  }
  int total = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    Ellipse& ellipse = ellipses[k];
    const Eigen::Vector2d& axes = ellipse.axes;
    std::array<double, gathering_probes>
        demand{};  // points that would suffice if the whole border were like this probe
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      const double c = probes()[i].real();
      const double s = probes()[i].imag();
      const double slope = std::sqrt(axes.x() * axes.x() * s * s + axes.y() * axes.y() * c * c);
      const Complex z = ellipse.centre + ellipse.turn * Complex(axes.x() * c, axes.y() * s);
      const Eigen::Vector2d place(z.real(), z.imag());
      const double depth = sheet.depth(place);
      if (depth < closest) return false;
      // The mirror image in the sheet's border is twice as far; an electrode may be at the border.
      const double electrode =
          (nodes_.positions.colwise() - place).colwise().squaredNorm().minCoeff();
      double nearest = std::min(2 * depth, std::sqrt(electrode));
      for (std::size_t other = 0; other < contacts.size(); ++other) {
        if (other == k) continue;
        const auto& border = m.borders[other];
        const double level = (border.to_unit * (place - contacts[other].centre)).norm() - 1;
        if (level * border.shorter < closest) return false;
        nearest = std::min(nearest, level * border.shorter);
      }
      demand[i] = options_.resolution * 2 * pi * slope / (spacing_over_distance * nearest);
    }
    const double least = options_.resolution * std::max(9.0, 2.1 * axes.x() / axes.y());
    ellipse.gathering = gathering_for(demand, least);
    const int even = 2 * static_cast<int>(std::ceil(ellipse.gathering.count / 2 - 1e-9));
    m.borders[k].first = total;
    m.borders[k].count = std::clamp(even, least_points, options_.most_points / 2 * 2);
    total += m.borders[k].count;
  }
  m.resize(total, stride_);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto& border = m.borders[k];
    const Ellipse& ellipse = ellipses[k];
    const double step = 2 * pi / border.count;
    const Complex towards = std::polar(1.0, ellipse.gathering.towards);
    const std::vector<Complex>& halves = halves_[static_cast<std::size_t>(border.count)];
    for (int i = 0; i < border.count; ++i) {
      const Gathered g = gathered(halves[static_cast<std::size_t>(i)], ellipse.gathering);
      const Complex on_circle = towards * g.turn;
      const double c = on_circle.real();
      const double s = on_circle.imag();
      const Complex offset = ellipse.turn * Complex(ellipse.axes.x() * c, ellipse.axes.y() * s);
      const Complex first = ellipse.turn * Complex(-ellipse.axes.x() * s, ellipse.axes.y() * c);
      const DiscPoint value = sheet.to_disc(ellipse.centre + offset);
      const double depth = 1 - std::norm(value.w);
      if (depth <= 0) return false;
      const Complex tangent = value.first * first;
      const Complex bend = value.second * first * first - value.first * offset;
      const double speed = length_of(tangent);
      const auto p = static_cast<std::size_t>(border.first + i);
      m.x[p] = value.w.real();
      m.y[p] = value.w.imag();
      m.normal_x[p] = tangent.imag() / speed;
      m.normal_y[p] = -tangent.real() / speed;
      m.curvature[p] = (std::conj(tangent) * bend).imag() / (speed * speed * speed);
      m.weight[p] = speed * g.slope * step;
      m.depth[p] = depth;
      m.tangent[p] = first * (g.slope * step);
      m.from_centre[p] = offset;
    }
  }
  m.contacts.assign(contacts.begin(), contacts.end());
  return true;
}

}  // namespace ertbench
