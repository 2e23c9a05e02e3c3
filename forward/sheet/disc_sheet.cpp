#include "forward/sheet/disc_sheet.h"

#include <cmath>
#include <numbers>

#include "forward/sheet/rasterise.h"

namespace ertbench {

DiscSheet::DiscSheet(double diameter_mm)
    : Sheet(Eigen::AlignedBox2d(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)), diameter_mm / 2),
      border_{BorderPiece::ellipse({0, 0}, {1, 0}, {0, 1})} {}

double DiscSheet::area() const { return std::numbers::pi; }

double DiscSheet::border_length() const { return 2 * std::numbers::pi; }

Eigen::Vector2d DiscSheet::border_point(double along) const {
  return {std::sin(along), std::cos(along)};
}

double DiscSheet::area_within(const Eigen::AlignedBox2d& box) const {
  Contact disc;
  disc.shape = Shape::disc;
  disc.half_size = {1, 1};
  return box.volume() * covered_fraction(disc, box);
}

std::vector<Eigen::Matrix2d> DiscSheet::symmetries() const { return square_sheet()->symmetries(); }

}  // namespace ertbench
