#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <complex>
#include <memory>
#include <string>
#include <vector>

#include "forward/sheet/pixel_grid.h"

namespace ertbench {

/// A point z = x + i y on a border, with its derivatives with respect to the border's parameter.
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
  /// Parameters at which this piece meets the other, including ends of common stretches.
  std::vector<double> crossings(const BorderPiece& other) const;
  bool passes_through(std::complex<double> point, double tolerance) const;

 private:
  /// Parameter of the nearest point to `point` on the straight line or the ellipse.
  double parameter_of(std::complex<double> point) const;
  /// |p|^2 - 1 with p in the ellipse's unit coordinates, zero on the ellipse.
  double level(std::complex<double> point) const;
  void cross_side(const BorderPiece& side, std::vector<double>& out) const;
  void cross_ellipse(const BorderPiece& ellipse, std::vector<double>& out) const;

  bool is_ellipse_ = false;
  std::complex<double> origin_, first_, second_;  ///< from, to - from, 0; centre and axes
};

/// The sides of a polygon, without those of no length.
std::vector<BorderPiece> polygon_border(const std::vector<Eigen::Vector2d>& vertices);

/// Image of a point of the sheet on the unit disc: w = S(z), with the derivatives S' and S''.
struct DiscPoint {
  std::complex<double> w, first, second;
};

/// The shape of a resistive sheet and its geometry. No other code assumes a shape: another shape is
/// another class derived from this.
///
/// Lengths are in domain units of `unit_mm` millimetres: half the square's side, half the
/// rectangle's longer side, the disc's radius, so that a sheet is 2 across. A sheet is convex and
/// contains the centre of its bounds.
class Sheet {
 public:
  virtual ~Sheet() = default;

  /// "square", "rectangle", "disc"; sheets of the same name and size are equal.
  virtual std::string name() const = 0;
  /// For descriptions: "[-1, 1] x [-1, 1]".
  virtual std::string extent() const = 0;

  const Eigen::AlignedBox2d& bounds() const { return bounds_; }
  double unit_mm() const { return unit_mm_; }  ///< length of a domain unit, mm
  Eigen::Vector2d size_mm() const { return unit_mm_ * bounds_.sizes(); }
  virtual double area() const = 0;
  /// Distance from the centre of the bounds to the farthest point of the border. Twice that is the
  /// largest possible localisation error.
  virtual double radius() const = 0;
  virtual double inner_radius() const = 0;  ///< of the largest disc about the centre

  /// Distance of a point to the border, positive on the sheet, negative beyond it.
  virtual double depth(const Eigen::Vector2d& point) const = 0;
  /// True if a box lies on the sheet, at least `margin` from its border.
  bool encloses(const Eigen::AlignedBox2d& box, double margin = 0) const;

  /// The border, piece by piece.
  virtual const std::vector<BorderPiece>& border() const = 0;
  virtual double border_length() const = 0;
  /// Point at a distance along the border, clockwise from `border_start`; any number, modulo the
  /// border's length.
  virtual Eigen::Vector2d border_point(double along) const = 0;
  virtual std::string border_start() const = 0;  ///< "the top left corner"

  /// The conformal map of the sheet onto the unit disc, under which div(sigma grad u) = 0 keeps its
  /// form. For points of the closed sheet; analytic beyond the border, so that contacts may touch
  /// it.
  virtual DiscPoint to_disc(std::complex<double> point) const = 0;

  /// Rotations and reflections about the centre that map the sheet onto itself, the identity first.
  virtual std::vector<Eigen::Matrix2d> symmetries() const = 0;

  /// Share of a box's area that is on the sheet.
  virtual double area_within(const Eigen::AlignedBox2d& box) const;

  /// Image with `side` pixels along the longer side of the bounds and nearly square pixels: `side`
  /// x `side` for a square or a disc. Visits every pixel unless the sheet fills its bounds; reuse
  /// the result for many images.
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

/// The square [-1, 1] x [-1, 1] of 200 mm on each side (Zheng et al.'s skin), the default sheet.
const std::shared_ptr<const Sheet>& square_sheet();

}  // namespace ertbench
