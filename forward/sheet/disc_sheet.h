#pragma once

#include "forward/sheet/sheet.h"

namespace ertbench {

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
  /// Those of a square image of it. A disc has more, but they would turn pixels onto parts of
  /// pixels.
  std::vector<Eigen::Matrix2d> symmetries() const override;

 private:
  std::vector<BorderPiece> border_;
};

}  // namespace ertbench
