#include "forward/sheet/sheet.h"

namespace ertbench {

bool Sheet::encloses(const Eigen::AlignedBox2d& box, double margin) const {
  using Corner = Eigen::AlignedBox2d::CornerType;
  for (const Corner corner : {Eigen::AlignedBox2d::BottomLeft, Eigen::AlignedBox2d::BottomRight,
                              Eigen::AlignedBox2d::TopLeft, Eigen::AlignedBox2d::TopRight}) {
    if (depth(box.corner(corner)) < margin) return false;
  }
  return true;
}

bool Sheet::fills_bounds() const { return area() > (1 - 1e-12) * bounds_.volume(); }

PixelGrid Sheet::pixels(int side) const {
  PixelGrid grid(bounds_, side, side);
  if (fills_bounds()) return grid;
  for (int p = 0; p < grid.count(); ++p) {
    if (depth(grid.centre(p)) < 0) grid.set_off_sheet(p);
  }
  return grid;
}

}  // namespace ertbench
