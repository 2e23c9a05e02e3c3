#include "forward/sheet/square_sheet.h"

#include <cmath>
#include <numbers>

namespace ertbench {

SquareSheet::SquareSheet(double side_mm)
    : Sheet(Eigen::AlignedBox2d(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)), side_mm / 2),
      border_(polygon_border({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})) {}

double SquareSheet::radius() const { return std::numbers::sqrt2; }

double SquareSheet::depth(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d beyond = point.cwiseAbs().array() - 1;
  if (beyond.maxCoeff() <= 0) return -beyond.maxCoeff();
  return -beyond.cwiseMax(0).norm();
}

Eigen::Vector2d SquareSheet::border_point(double along) const {
  const int side = (static_cast<int>(std::floor(along / 2)) % 4 + 4) % 4;
  const double t = along - 2 * std::floor(along / 2) - 1;
  switch (side) {
    case 0:
      return {t, 1};
    case 1:
      return {1, -t};
    case 2:
      return {-t, -1};
    default:
      return {-1, t};
  }
}

std::vector<Eigen::Matrix2d> SquareSheet::symmetries() const {
  std::vector<Eigen::Matrix2d> out;
  const Eigen::Matrix2d quarter{{0, -1}, {1, 0}};
  const Eigen::Matrix2d mirror{{-1, 0}, {0, 1}};
  for (const bool reflected : {false, true}) {
    Eigen::Matrix2d turn = reflected ? mirror : Eigen::Matrix2d::Identity();
    for (int rotation = 0; rotation < 4; ++rotation, turn = quarter * turn) out.push_back(turn);
  }
  return out;
}

const std::shared_ptr<const Sheet>& square_sheet() {
  static const std::shared_ptr<const Sheet> sheet = std::make_shared<const SquareSheet>(200);
  return sheet;
}

}  // namespace ertbench
