#pragma once

#include <complex>
#include <vector>

#include "forward/sheet/sheet.h"

namespace ertbench {

/// The conformal map w = S(z) of the square [-1, 1] x [-1, 1] (z = x + i y) onto the unit disc.
///
/// div(sigma grad u) = 0 keeps its form under it, and on the disc the Neumann function is
/// elementary: N(w, v) = -(ln|w - v| + ln|1 - w conj(v)|) / 2 pi. S is the lemniscate sine of the
/// turned square, S(z) = sl(c z) with c = varpi / (2 sqrt 2) e^(-i pi / 4), which takes the corners
/// to 1, i, -1, -i. It is analytic beyond the border, so contacts may touch it.
class SquareMap {
 public:
  SquareMap();

  /// For z in the closed square; S to 1e-15. S' vanishes in the corners, where it is good to 1e-8.
  DiscPoint operator()(std::complex<double> z) const;

 private:
  std::vector<double> series_;  ///< of sl(t) / t in powers of t^4
};

/// The conformal map of the rectangle [-a, a] x [-b, b] onto the unit disc, with the centre to 0
/// (see SquareMap for its purpose).
///
/// sn maps a rectangle to the half plane, and a Moebius map takes that to the disc. With the theta
/// functions of nome q = exp(-2 pi L), L = longer / shorter side, and v = pi z / (2 s) + i pi L /
/// 2, where s is half the shorter side, turned onto the real axis,
///
///     w = (theta_1(v) - i theta_4(v)) / (theta_1(v) + i theta_4(v)),
///     w' = 2 i theta_4(0)^2 theta_2(v) theta_3(v) / (theta_1(v) + i theta_4(v))^2,
///
/// by (theta_1 / theta_4)' = theta_4(0)^2 theta_2 theta_3 / theta_4^2. With this orientation q is
/// at most exp(-2 pi), and four terms are exact. Analytic beyond the border.
class RectangleMap {
 public:
  RectangleMap(double half_width, double half_height);

  DiscPoint operator()(std::complex<double> z) const;

 private:
  bool turned_;
  double scale_;  ///< v = scale z + i lift
  double lift_;
  double nome_;
  double squared_theta_;  ///< theta_4(0)^2
};

/// The square [-1, 1] x [-1, 1]. Its border is counted from the corner (-1, 1).
class SquareSheet : public Sheet {
 public:
  explicit SquareSheet(double side_mm);

  std::string name() const override { return "square"; }
  std::string extent() const override { return "[-1, 1] x [-1, 1]"; }
  double area() const override { return 4; }
  double radius() const override;
  double inner_radius() const override { return 1; }
  double depth(const Eigen::Vector2d& point) const override;
  const std::vector<BorderPiece>& border() const override { return border_; }
  double border_length() const override { return 8; }
  Eigen::Vector2d border_point(double along) const override;
  std::string border_start() const override { return "the top left corner"; }
  DiscPoint to_disc(std::complex<double> point) const override { return map_(point); }
  std::vector<Eigen::Matrix2d> symmetries() const override;

 private:
  SquareMap map_;
  std::vector<BorderPiece> border_;
};

/// A rectangle about the origin, its longer side from -1 to 1. Its border is counted from the top
/// left corner.
class RectangleSheet : public Sheet {
 public:
  /// Limit of longer over shorter side. The map to the disc crowds the corners of the shorter
  /// sides: at 5 to 1 they are 3e-3 of the disc apart, which leaves an accuracy of 1e-9.
  static constexpr double most_elongation = 5;

  explicit RectangleSheet(const Eigen::Vector2d& sides_mm);

  std::string name() const override { return "rectangle"; }
  std::string extent() const override;
  double area() const override { return 4 * half_.prod(); }
  double radius() const override { return half_.norm(); }
  double inner_radius() const override { return half_.minCoeff(); }
  double depth(const Eigen::Vector2d& point) const override;
  const std::vector<BorderPiece>& border() const override { return border_; }
  double border_length() const override { return 4 * half_.sum(); }
  Eigen::Vector2d border_point(double along) const override;
  std::string border_start() const override { return "the top left corner"; }
  DiscPoint to_disc(std::complex<double> point) const override { return map_(point); }
  std::vector<Eigen::Matrix2d> symmetries() const override;

 private:
  explicit RectangleSheet(const Eigen::Vector2d& half, double unit_mm);

  Eigen::Vector2d half_;  ///< of the sides
  RectangleMap map_;
  std::vector<BorderPiece> border_;
};

/// The disc x^2 + y^2 <= 1. Its border is counted from the top, (0, 1).
class DiscSheet : public Sheet {
 public:
  explicit DiscSheet(double diameter_mm);

  std::string name() const override { return "disc"; }
  std::string extent() const override { return "x^2 + y^2 <= 1"; }
  double area() const override;
  double radius() const override { return 1; }
  double inner_radius() const override { return 1; }
  double depth(const Eigen::Vector2d& point) const override { return 1 - point.norm(); }
  const std::vector<BorderPiece>& border() const override { return border_; }
  double border_length() const override;
  Eigen::Vector2d border_point(double along) const override;
  std::string border_start() const override { return "the top"; }
  DiscPoint to_disc(std::complex<double> point) const override { return {point, 1, 0}; }
  double area_within(const Eigen::AlignedBox2d& box) const override;
  /// The symmetries of its square image; other rotations would not map pixels onto pixels.
  std::vector<Eigen::Matrix2d> symmetries() const override;

 private:
  std::vector<BorderPiece> border_;
};

}  // namespace ertbench
