#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace ertbench {

/// A point on a border and its derivatives by the border's parameter; z = x + i y.
struct BorderPoint {
  std::complex<double> z, first, second;
};

/// A straight side or a whole ellipse.
class BorderPiece {
 public:
  /// Lengths below this are rounding.
  static constexpr double tolerance = 1e-9;

  static BorderPiece side(const Eigen::Vector2d& from, const Eigen::Vector2d& to);
  static BorderPiece ellipse(const Eigen::Vector2d& centre, const Eigen::Vector2d& first_axis,
                             const Eigen::Vector2d& second_axis);

  bool is_ellipse() const { return is_ellipse_; }
  double elongation() const;  ///< longer over shorter semi-axis, 1 for a side
  /// The parameter runs over [0, length()]: the angle of an ellipse, 0 to 1 along a side.
  double length() const;
  BorderPoint at(double parameter) const;
  /// Parameters at which this piece meets the other, ends of common stretches included.
  std::vector<double> crossings(const BorderPiece& other) const;
  bool passes_through(std::complex<double> point, double tolerance) const;

 private:
  /// Parameter of the point of the straight line or of the ellipse next to `point`.
  double parameter_of(std::complex<double> point) const;
  /// |p|^2 - 1 with p in the ellipse's unit coordinates; its zeros are the ellipse.
  double level(std::complex<double> point) const;
  void cross_side(const BorderPiece& side, std::vector<double>& out) const;
  void cross_ellipse(const BorderPiece& ellipse, std::vector<double>& out) const;

  bool is_ellipse_ = false;
  std::complex<double> origin_, first_, second_;  ///< from, to - from, 0; centre and axes
};

/// The sides of a polygon, those of no length left out.
std::vector<BorderPiece> polygon_border(const std::vector<Eigen::Vector2d>& vertices);

}  // namespace ertbench
