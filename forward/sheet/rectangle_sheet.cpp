#include "forward/sheet/rectangle_sheet.h"

#include <cmath>

#include "core/text.h"

namespace ertbench {

using Eigen::Vector2d;

RectangleSheet::RectangleSheet(const Vector2d& sides_mm)
    : RectangleSheet(sides_mm / sides_mm.maxCoeff(), sides_mm.maxCoeff() / 2) {}

RectangleSheet::RectangleSheet(const Vector2d& half, double unit_mm)
    : Sheet(Eigen::AlignedBox2d(Vector2d(-half), half), unit_mm),
      half_(half),
      map_(half.x(), half.y()),
      border_(polygon_border({{-half.x(), -half.y()},
                              {half.x(), -half.y()},
                              {half.x(), half.y()},
                              {-half.x(), half.y()}})) {}

std::string RectangleSheet::extent() const {
  const auto interval = [](double half) {
    return "[-" + number_text(half) + ", " + number_text(half) + "]";
  };
  return interval(half_.x()) + " x " + interval(half_.y());
}

double RectangleSheet::depth(const Vector2d& point) const {
  const Vector2d beyond = point.cwiseAbs() - half_;
  if (beyond.maxCoeff() <= 0) return -beyond.maxCoeff();
  return -beyond.cwiseMax(0).norm();
}

Vector2d RectangleSheet::border_point(double along) const {
  const double width = 2 * half_.x();
  const double height = 2 * half_.y();
  double t = along - border_length() * std::floor(along / border_length());
  if (t < width) return {t - half_.x(), half_.y()};
  t -= width;
  if (t < height) return {half_.x(), half_.y() - t};
  t -= height;
  if (t < width) return {half_.x() - t, -half_.y()};
  return {-half_.x(), t - width - half_.y()};
}

std::vector<Eigen::Matrix2d> RectangleSheet::symmetries() const {
  std::vector<Eigen::Matrix2d> out;
  for (const double y : {1.0, -1.0}) {
    for (const double x : {1.0, -1.0}) {
      out.emplace_back(Eigen::Vector2d(x, y).asDiagonal());
    }
  }
  return out;
}

}  // namespace ertbench
