#pragma once

#include <complex>
#include <vector>

#include "forward/sheet/scene.h"

namespace ertbench {

/// A point on a contact's border and its derivatives by the border's parameter; z = x + i y.
struct BorderPoint {
  std::complex<double> z, first, second;
};

/// A straight side or a whole ellipse.
class BorderPiece {
 public:
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

/// A stretch of a contact's border along which the conductivity jumps from one value to another.
struct ContactArc {
  BorderPiece piece;
  double begin = 0;
  double end = 0;
  bool closed = false;  ///< a whole ellipse; else both ends are corners or junctions
  bool begins_at_sheet =
      false;  ///< the end lies on the sheet's border, where its mirror image joins
  bool ends_at_sheet = false;
  double left = 1;        ///< conductivity / background on the left of the direction of travel
  double right = 1;       ///< and on the right
  int contact = 0;        ///< whose border it is
  int left_contact = -1;  ///< which contact's conductivity `left` is, -1 the background
  int right_contact = -1;
};

/// The contacts that cover a point: the one whose ratio counts there, -1 where there is none.
int contact_at(const Scene& scene, std::complex<double> point);
double ratio_at(const Scene& scene, std::complex<double> point);

/// All stretches of border within the sheet at which the conductivity jumps: borders hidden in a
/// contact of lower ratio are left out, what several contacts share is there once. Exact up to
/// rounding for every scene, whatever overlaps or sticks out.
std::vector<ContactArc> contact_arcs(const Scene& scene);

}  // namespace ertbench
