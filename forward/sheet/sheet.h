#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "forward/sheet/pixel_grid.h"

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

/// A point of the sheet taken to the unit disc: w = S(z), and the derivatives S' and S''.
struct DiscPoint {
  std::complex<double> w, first, second;
};

/// The shape of a resistive sheet, and all that follows from it. Everything else asks the sheet
/// and takes no shape for granted: another sheet is another class of this kind.
///
/// Lengths are in domain units: half the square's side, half the rectangle's longer side, the
/// disc's radius, so that a sheet is 2 across; `unit_mm` says how long one is. A sheet is convex
/// and the middle of its bounds lies in it.
class Sheet {
 public:
  virtual ~Sheet() = default;

  /// Sheets of the same name and size are the same: "square", "rectangle", "disc".
  virtual std::string name() const = 0;
  /// As it stands in descriptions: "[-1, 1] x [-1, 1]".
  virtual std::string extent() const = 0;

  const Eigen::AlignedBox2d& bounds() const { return bounds_; }
  double unit_mm() const { return unit_mm_; }  ///< length of a domain unit, mm
  Eigen::Vector2d size_mm() const { return unit_mm_ * bounds_.sizes(); }
  virtual double area() const = 0;
  /// From the middle of the bounds to the farthest point of the border; twice that is the longest
  /// error a place on the sheet can have.
  virtual double radius() const = 0;
  virtual double inner_radius() const = 0;  ///< of the largest disc around the middle

  /// Distance of a point to the border, positive on the sheet, negative beyond it.
  virtual double depth(const Eigen::Vector2d& point) const = 0;
  /// Whether a box lies in the sheet, at least `margin` from its border.
  bool encloses(const Eigen::AlignedBox2d& box, double margin = 0) const;

  /// The border, piece by piece.
  virtual const std::vector<BorderPiece>& border() const = 0;
  virtual double border_length() const = 0;
  /// The point of the border at a distance along it, clockwise from where electrodes are counted
  /// from; any number, the border is gone round as often as it takes.
  virtual Eigen::Vector2d border_point(double along) const = 0;
  virtual std::string border_start() const = 0;  ///< "the top left corner"

  /// The conformal map of the sheet onto the unit disc, under which div(sigma grad u) = 0 keeps its
  /// form. For points of the closed sheet; analytic beyond the border, so that contacts may touch
  /// it.
  virtual DiscPoint to_disc(std::complex<double> point) const = 0;

  /// The rotations and reflections about the middle that leave the sheet as it is, the identity
  /// first.
  virtual std::vector<Eigen::Matrix2d> symmetries() const = 0;

  /// The part of the area of a box that is on the sheet.
  virtual double area_within(const Eigen::AlignedBox2d& box) const;

  /// An image of `side` pixels along the longer side of the bounds, and along the other of so many
  /// that pixels are as good as square: `side` x `side` on a square and a disc. Costs a look at
  /// every pixel unless the sheet fills its bounds: make it once for many images.
  PixelGrid pixels(int side) const;
  int image_columns(int side) const;
  int image_rows(int side) const;
  bool fills_bounds() const;

 protected:
  Sheet(const Eigen::AlignedBox2d& bounds, double unit_mm) : bounds_(bounds), unit_mm_(unit_mm) {}
  Sheet(const Sheet&) = default;
  Sheet& operator=(const Sheet&) = default;

 private:
  Eigen::AlignedBox2d bounds_;
  double unit_mm_;
};

/// The square [-1, 1] x [-1, 1] of 200 mm on each side (Zheng et al.'s skin), the sheet of every
/// sensor that names no other.
const std::shared_ptr<const Sheet>& square_sheet();

}  // namespace ertbench
