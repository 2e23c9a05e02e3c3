#pragma once

#include "forward/sheet/rectangle_map.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// A rectangle about the origin, its longer side from -1 to 1. Its border is counted from the top
/// left corner.
class RectangleSheet : public Sheet {
 public:
  /// Longer over shorter side. The map to the disc crowds the corners of the shorter sides: at 5 to
  /// 1 they are 3e-3 of the disc apart, and what is left of double precision is still 1e-9.
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

}  // namespace ertbench
