#pragma once

#include "forward/sheet/sheet.h"
#include "forward/sheet/square_map.h"

namespace ertbench {

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

}  // namespace ertbench
