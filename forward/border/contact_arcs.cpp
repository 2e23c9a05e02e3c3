#include "forward/border/contact_arcs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Lengths below this are rounding; the probe of what lies beside a border goes this far.
constexpr double tolerance = 1e-9;

Complex complex(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
Eigen::Vector2d vector(Complex z) { return {z.real(), z.imag()}; }
double dot(Complex a, Complex b) { return a.real() * b.real() + a.imag() * b.imag(); }
double cross(Complex a, Complex b) { return a.real() * b.imag() - a.imag() * b.real(); }

bool in_sheet(Complex z, double margin) {
  return std::max(std::abs(z.real()), std::abs(z.imag())) < 1 - margin;
}

std::vector<BorderPiece> sides(const std::vector<Eigen::Vector2d>& vertices) {
  std::vector<BorderPiece> out;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const Eigen::Vector2d& next = vertices[(v + 1) % vertices.size()];
    if ((next - vertices[v]).norm() > tolerance) {
      out.push_back(BorderPiece::side(vertices[v], next));
    }
  }
  return out;
}

std::vector<BorderPiece> border_of(const Contact& contact) {
  if (contact.shape == Shape::polygon) return sides(contact.vertices);
  const Eigen::Vector2d u =
      contact.half_size.x() * Eigen::Vector2d(std::cos(contact.angle), std::sin(contact.angle));
  const Eigen::Vector2d v =
      contact.half_size.y() * Eigen::Vector2d(-std::sin(contact.angle), std::cos(contact.angle));
  const Eigen::Vector2d& c = contact.centre;
  if (contact.shape == Shape::rectangle) return sides({c - u - v, c + u - v, c + u + v, c - u + v});
  return {BorderPiece::ellipse(c, u, v)};
}

const std::vector<BorderPiece>& sheet_sides() {
  static const std::vector<BorderPiece> out = sides({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}});
  return out;
}

/// Zeros of a smooth periodic function of few waves: sign changes between samples, and pairs of
/// zeros on either side of an extremum between them.
template <typename F>
std::vector<double> zeros(const F& f) {
  constexpr int samples = 32;
  constexpr double step = 2 * pi / samples;
  const auto bisect = [&](double a, double b) {
    const bool rising = f(a) < 0;
    for (int i = 0; i < 60; ++i) {
      const double middle = (a + b) / 2;
      ((f(middle) < 0) == rising ? a : b) = middle;
    }
    return (a + b) / 2;
  };
  std::vector<double> out;
  for (int i = 0; i < samples; ++i) {
    const double t = i * step;
    const double here = f(t);
    const double next = f(t + step);
    if ((here < 0) != (next < 0)) {
      out.push_back(bisect(t, t + step));
      continue;
    }
    const double before = f(t - step);
    const double sign = here < 0 ? -1 : 1;
    if (!(sign * here <= sign * before && sign * here <= sign * next &&
          (before < 0) == (here < 0))) {
      continue;
    }
    double a = t - step;  // the extremum lies in [a, b]
    double b = t + step;
    for (int k = 0; k < 60; ++k) {
      const double left = a + (b - a) / 3;
      const double right = b - (b - a) / 3;
      (sign * f(left) < sign * f(right) ? b : a) = sign * f(left) < sign * f(right) ? right : left;
    }
    const double peak = (a + b) / 2;
    if (sign * f(peak) < 0) {
      out.push_back(bisect(t - step, peak));
      out.push_back(bisect(peak, t + step));
    }
  }
  return out;
}

}  // namespace

BorderPiece BorderPiece::side(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  BorderPiece piece;
  piece.origin_ = complex(from);
  piece.first_ = complex(to - from);
  return piece;
}

BorderPiece BorderPiece::ellipse(const Eigen::Vector2d& centre, const Eigen::Vector2d& first_axis,
                                 const Eigen::Vector2d& second_axis) {
  BorderPiece piece;
  piece.is_ellipse_ = true;
  piece.origin_ = complex(centre);
  piece.first_ = complex(first_axis);
  piece.second_ = complex(second_axis);
  return piece;
}

double BorderPiece::length() const { return is_ellipse_ ? 2 * pi : 1; }

double BorderPiece::elongation() const {
  if (!is_ellipse_) return 1;
  const double ratio = std::abs(first_) / std::abs(second_);
  return std::max(ratio, 1 / ratio);
}

BorderPoint BorderPiece::at(double t) const {
  if (!is_ellipse_) return {origin_ + t * first_, first_, 0};
  const Complex radius = std::cos(t) * first_ + std::sin(t) * second_;
  return {origin_ + radius, std::cos(t) * second_ - std::sin(t) * first_, -radius};
}

double BorderPiece::parameter_of(Complex point) const {
  const Complex d = point - origin_;
  if (!is_ellipse_) return dot(d, first_) / std::norm(first_);
  const double angle =
      std::atan2(dot(d, second_) / std::norm(second_), dot(d, first_) / std::norm(first_));
  return angle < 0 ? angle + 2 * pi : angle;
}

double BorderPiece::level(Complex point) const {
  const Complex d = point - origin_;
  const double along = dot(d, first_) / std::norm(first_);
  const double across = dot(d, second_) / std::norm(second_);
  return along * along + across * across - 1;
}

bool BorderPiece::passes_through(Complex point, double distance) const {
  if (is_ellipse_) {
    return std::abs(level(point)) * std::sqrt(std::min(std::norm(first_), std::norm(second_))) <
           2 * distance;
  }
  const double t = parameter_of(point);
  return t >= 0 && t <= 1 && std::abs(cross(first_, point - origin_)) < distance * std::abs(first_);
}

void BorderPiece::cross_side(const BorderPiece& other, std::vector<double>& out) const {
  const double other_length = std::abs(other.first_);
  const auto on_other = [&](Complex point) {
    const double t = other.parameter_of(point);
    return t * other_length > -tolerance && (t - 1) * other_length < tolerance;
  };
  if (is_ellipse_) {  // cross(other.first, point - other.origin) is one wave round the ellipse
    const double constant = cross(other.first_, origin_ - other.origin_);
    const double cosine = cross(other.first_, first_);
    const double sine = cross(other.first_, second_);
    const double ratio = -constant / std::hypot(cosine, sine);
    if (std::abs(ratio) >= 1) return;
    for (const double turn : {-1.0, 1.0}) {
      const double t = std::atan2(sine, cosine) + turn * std::acos(ratio);
      if (on_other(at(t).z)) out.push_back(t - 2 * pi * std::floor(t / (2 * pi)));
    }
    return;
  }
  const double area = cross(first_, other.first_);
  if (std::abs(area) > 1e-12 * std::abs(first_) * other_length) {
    const double t = cross(other.origin_ - origin_, other.first_) / area;
    if (on_other(at(t).z)) out.push_back(t);
  } else if (std::abs(cross(first_, other.origin_ - origin_)) < tolerance * std::abs(first_)) {
    out.push_back(parameter_of(other.origin_));  // along one line
    out.push_back(parameter_of(other.origin_ + other.first_));
  }
}

void BorderPiece::cross_ellipse(const BorderPiece& other, std::vector<double>& out) const {
  if (is_ellipse_) {
    bool same = true;  // four waves at most, so that eight points tell
    for (int i = 0; i < 8 && same; ++i) same = other.passes_through(at(i * pi / 4).z, tolerance);
    if (same) return;
    const std::vector<double> found = zeros([&](double t) { return other.level(at(t).z); });
    for (const double t : found) out.push_back(t - 2 * pi * std::floor(t / (2 * pi)));
    return;
  }
  // |start + t step|^2 = 1 in the ellipse's unit coordinates.
  const auto unit = [&](Complex d) {
    return Complex(dot(d, other.first_) / std::norm(other.first_),
                   dot(d, other.second_) / std::norm(other.second_));
  };
  const Complex start = unit(origin_ - other.origin_);
  const Complex step = unit(first_);
  const double half = dot(start, step);
  const double discriminant = half * half - std::norm(step) * (std::norm(start) - 1);
  if (discriminant <= 0) return;
  for (const double sign : {-1.0, 1.0}) {
    out.push_back((-half + sign * std::sqrt(discriminant)) / std::norm(step));
  }
}

std::vector<double> BorderPiece::crossings(const BorderPiece& other) const {
  std::vector<double> out;
  if (other.is_ellipse_) {
    cross_ellipse(other, out);
  } else {
    cross_side(other, out);
  }
  std::erase_if(out, [&](double t) { return !(t >= 0 && t <= length()); });
  return out;
}

int contact_at(const Scene& scene, Complex point) {
  int lowest = -1;
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    if (!scene.contacts[k].contains(vector(point))) continue;
    if (lowest < 0 || scene.contacts[k].conductivity_ratio <
                          scene.contacts[static_cast<std::size_t>(lowest)].conductivity_ratio) {
      lowest = static_cast<int>(k);
    }
  }
  return lowest;
}

double ratio_at(const Scene& scene, Complex point) {
  const int contact = contact_at(scene, point);
  return contact < 0 ? 1 : scene.contacts[static_cast<std::size_t>(contact)].conductivity_ratio;
}

std::vector<ContactArc> contact_arcs(const Scene& scene) {
  std::vector<std::vector<BorderPiece>> borders;
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const Contact& contact : scene.contacts) {
    borders.push_back(border_of(contact));
    boxes.push_back(contact.bounds());
  }
  const Eigen::AlignedBox2d sheet(Eigen::Vector2d(-1 + tolerance, -1 + tolerance),
                                  Eigen::Vector2d(1 - tolerance, 1 - tolerance));
  std::vector<ContactArc> arcs;
  std::vector<double> cuts;
  for (std::size_t k = 0; k < borders.size(); ++k) {
    const bool sticks_out = !sheet.contains(boxes[k]);
    for (const BorderPiece& piece : borders[k]) {
      cuts.clear();
      const auto cut_at = [&](const std::vector<BorderPiece>& others) {
        for (const BorderPiece& other : others) {
          const std::vector<double> found = piece.crossings(other);
          cuts.insert(cuts.end(), found.begin(), found.end());
        }
      };
      for (std::size_t other = 0; other < borders.size(); ++other) {
        if (other != k && boxes[other].intersects(boxes[k])) cut_at(borders[other]);
      }
      if (sticks_out) cut_at(sheet_sides());
      std::sort(cuts.begin(), cuts.end());
      const bool closed = piece.is_ellipse() && cuts.empty();
      if (piece.is_ellipse() && !closed) {
        cuts.push_back(cuts.front() + 2 * pi);
      } else {
        cuts.insert(cuts.begin(), 0.0);
        cuts.push_back(piece.length());
      }
      for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
        ContactArc arc{.piece = piece, .begin = cuts[c], .end = cuts[c + 1], .closed = closed};
        const BorderPoint middle = piece.at((arc.begin + arc.end) / 2);
        if ((arc.end - arc.begin) * std::abs(middle.first) < tolerance) continue;
        if (!in_sheet(middle.z, tolerance)) continue;
        const Complex left = Complex(0, tolerance) * middle.first / std::abs(middle.first);
        arc.contact = static_cast<int>(k);
        arc.left_contact = contact_at(scene, middle.z + left);
        arc.right_contact = contact_at(scene, middle.z - left);
        arc.left = ratio_at(scene, middle.z + left);
        arc.right = ratio_at(scene, middle.z - left);
        if (arc.left == arc.right) continue;
        const bool is_there = std::any_of(
            borders.begin(), borders.begin() + static_cast<std::ptrdiff_t>(k), [&](const auto& b) {
              return std::any_of(b.begin(), b.end(), [&](const BorderPiece& earlier) {
                return earlier.passes_through(middle.z, tolerance);
              });
            });
        if (is_there) continue;
        arc.begins_at_sheet = !in_sheet(piece.at(arc.begin).z, 2 * tolerance);
        arc.ends_at_sheet = !in_sheet(piece.at(arc.end).z, 2 * tolerance);
        arcs.push_back(arc);
      }
    }
  }
  return arcs;
}

}  // namespace ertbench
