#include "forward/sheet/sheet.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "forward/sheet/cross.h"

namespace ertbench {
namespace {

using std::numbers::pi;

using Complex = std::complex<double>;

constexpr double tolerance = BorderPiece::tolerance;

Complex complex(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
double dot(Complex a, Complex b) { return a.real() * b.real() + a.imag() * b.imag(); }

/// Zeros of a smooth periodic function of few waves, from sign changes between samples and pairs of
/// zeros about an extremum between them.
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

/// A pixel with a smaller share of its area on the sheet counts as off it.
constexpr double least_part = 0.01;

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
    out.push_back(parameter_of(other.origin_));  // both on one line
    out.push_back(parameter_of(other.origin_ + other.first_));
  }
}

void BorderPiece::cross_ellipse(const BorderPiece& other, std::vector<double>& out) const {
  if (is_ellipse_) {
    bool same = true;  // at most four waves, so that eight points decide
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

std::vector<BorderPiece> polygon_border(const std::vector<Eigen::Vector2d>& vertices) {
  std::vector<BorderPiece> out;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const Eigen::Vector2d& next = vertices[(v + 1) % vertices.size()];
    if ((next - vertices[v]).norm() > tolerance) {
      out.push_back(BorderPiece::side(vertices[v], next));
    }
  }
  return out;
}

bool Sheet::encloses(const Eigen::AlignedBox2d& box, double margin) const {
  using Corner = Eigen::AlignedBox2d::CornerType;
  for (const Corner corner : {Eigen::AlignedBox2d::BottomLeft, Eigen::AlignedBox2d::BottomRight,
                              Eigen::AlignedBox2d::TopLeft, Eigen::AlignedBox2d::TopRight}) {
    if (depth(box.corner(corner)) < margin) return false;
  }
  return true;
}

bool Sheet::fills_bounds() const { return area() > (1 - 1e-12) * bounds_.volume(); }

double Sheet::area_within(const Eigen::AlignedBox2d& box) const {
  if (fills_bounds()) return box.intersects(bounds_) ? box.intersection(bounds_).volume() : 0.0;
  constexpr int parts = 32;
  const Eigen::Vector2d step = box.sizes() / parts;
  int inside = 0;
  for (int i = 0; i < parts * parts; ++i) {
    const Eigen::Vector2d at(i % parts + 0.5, i / parts + 0.5);
    inside += depth(box.min() + step.cwiseProduct(at)) >= 0;
  }
  return box.volume() * inside / (parts * parts);
}

int Sheet::image_columns(int side) const {
  const Eigen::Vector2d size = bounds_.sizes();
  return static_cast<int>(std::max(1L, std::lround(side * size.x() / size.maxCoeff())));
}

int Sheet::image_rows(int side) const {
  const Eigen::Vector2d size = bounds_.sizes();
  return static_cast<int>(std::max(1L, std::lround(side * size.y() / size.maxCoeff())));
}

PixelGrid Sheet::pixels(int side) const {
  PixelGrid grid(bounds_, image_columns(side), image_rows(side));
  if (fills_bounds()) return grid;
  for (int p = 0; p < grid.count(); ++p) {
    if (encloses(grid.box(p))) continue;
    const double part = area_within(grid.box(p)) / grid.pixel_area();
    if (part < least_part) {
      grid.set_off_sheet(p);
    } else {
      grid.set_part_on_sheet(p, part);
    }
  }
  return grid;
}

}  // namespace ertbench
