#include "forward/sheet/sheet.h"

#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

/// Of a pixel's area: with less of it on the sheet a pixel is off it.
constexpr double least_part = 0.01;

}  // namespace

bool Sheet::encloses(const Eigen::AlignedBox2d& box, double margin) const {
  using Corner = Eigen::AlignedBox2d::CornerType;
  for (const Corner corner : {Eigen::AlignedBox2d::BottomLeft, Eigen::AlignedBox2d::BottomRight,
                              Eigen::AlignedBox2d::TopLeft, Eigen::AlignedBox2d::TopRight}) {
    if (depth(box.corner(corner)) < margin) return false;
  }
  return true;
}

bool Sheet::fills_bounds() const { return area() > (1 - 1e-12) * bounds_.volume(); }

double Sheet::area_within(const Eigen::AlignedBox2d& box) const {
  if (fills_bounds()) return box.intersects(bounds_) ? box.intersection(bounds_).volume() : 0.0;
  constexpr int parts = 32;
  const Eigen::Vector2d step = box.sizes() / parts;
  int inside = 0;
  for (int i = 0; i < parts * parts; ++i) {
    const Eigen::Vector2d at(i % parts + 0.5, i / parts + 0.5);
    inside += depth(box.min() + step.cwiseProduct(at)) >= 0;
  }
  return box.volume() * inside / (parts * parts);
}

int Sheet::image_columns(int side) const {
  const Eigen::Vector2d size = bounds_.sizes();
  return static_cast<int>(std::max(1L, std::lround(side * size.x() / size.maxCoeff())));
}

int Sheet::image_rows(int side) const {
  const Eigen::Vector2d size = bounds_.sizes();
  return static_cast<int>(std::max(1L, std::lround(side * size.y() / size.maxCoeff())));
}

PixelGrid Sheet::pixels(int side) const {
  PixelGrid grid(bounds_, image_columns(side), image_rows(side));
  if (fills_bounds()) return grid;
  for (int p = 0; p < grid.count(); ++p) {
    if (encloses(grid.box(p))) continue;
    const double part = area_within(grid.box(p)) / grid.pixel_area();
    if (part < least_part) {
      grid.set_off_sheet(p);
    } else {
      grid.set_part_on_sheet(p, part);
    }
  }
  return grid;
}

}  // namespace ertbench
