#include "forward/sheet/pixel_grid.h"

#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

/// Share of one row or column of pixels that a patch covers.
struct Overlap {
  int patch;
  double share;
};

/// The patches that overlap each of `pixels` equal parts of the side.
std::vector<std::vector<Overlap>> overlaps(int patches, double width, int pixels) {
  std::vector<std::vector<Overlap>> out(static_cast<std::size_t>(pixels));
  const double pixel = static_cast<double>(patches) / pixels;  // in units of the patch spacing
  for (int i = 0; i < pixels; ++i) {
    const double low = i * pixel;
    const double high = (i + 1) * pixel;
    const int first = static_cast<int>(std::floor(low + 1e-12));
    for (int p = first; p < patches && p < high; ++p) {
      const double from = std::max(low, p + (1 - width) / 2);
      const double to = std::min(high, p + (1 + width) / 2);
      if (to > from) out[static_cast<std::size_t>(i)].push_back({p, (to - from) / pixel});
    }
  }
  return out;
}

}  // namespace

void rasterise(const PatchField& field, const PixelGrid& pixels,
               Eigen::Ref<Eigen::VectorXd> ratio) {
  const auto columns = overlaps(field.patches, field.width, pixels.columns());
  const auto rows = overlaps(field.patches, field.width, pixels.rows());
  for (int row = 0; row < pixels.rows(); ++row) {
    for (int column = 0; column < pixels.columns(); ++column) {
      double change = 0;
      for (const Overlap& y : rows[static_cast<std::size_t>(row)]) {
        for (const Overlap& x : columns[static_cast<std::size_t>(column)]) {
          change += y.share * x.share * (field.ratio[x.patch + field.patches * y.patch] - 1);
        }
      }
      ratio[column + pixels.columns() * row] = 1 + change;
    }
  }
}

}  // namespace ertbench
