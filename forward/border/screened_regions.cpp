#include "forward/border/screened_regions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace ertbench {
namespace {

/// Arcs that hang together, all with the conductivity in question on one side.
struct Outline {
  std::vector<int> arcs;
  int sheet_ends = 0;
  double area = 0;  ///< of the region if it lies within, negative if it lies around
  /// Of the region's stretch of the sheet's border, counter-clockwise.
  double begin = 0, end = 0;
};

double angle_of(const Sheet& sheet, std::complex<double> point) {
  return std::arg(sheet.to_disc(point).w);
}

/// How far it is counter-clockwise from one angle to another.
double turn(double from, double to) {
  const double angle = std::fmod(to - from, 2 * std::numbers::pi);
  return angle < 0 ? angle + 2 * std::numbers::pi : angle;
}

bool is_same(double a, double b) { return std::abs(a - b) < 1e-12 * std::abs(b); }

/// The outlines of everything of conductivity `ratio`.
std::vector<Outline> outlines(const Sheet& sheet, const BorderLayout& layout,
                              const BorderPoints& points, double ratio) {
  std::vector<Outline> out;
  std::vector<char> is_taken(layout.arcs.size(), 0);
  const auto bounds = [&](std::size_t a) {
    return is_same(layout.arcs[a].left, ratio) || is_same(layout.arcs[a].right, ratio);
  };
  for (std::size_t start = 0; start < layout.arcs.size(); ++start) {
    if (is_taken[start] || !bounds(start)) continue;
    Outline outline;
    outline.arcs.push_back(static_cast<int>(start));
    is_taken[start] = 1;
    for (std::size_t k = 0; k < outline.arcs.size(); ++k) {
      const auto a = static_cast<std::size_t>(outline.arcs[k]);
      const ContactArc& arc = layout.arcs[a];
      const bool is_left = is_same(arc.left, ratio);
      const auto meets_sheet = [&](double parameter, bool is_begin) {
        ++outline.sheet_ends;
        // Seen from the left of the way into the sheet its border runs towards the end.
        const double angle = angle_of(sheet, arc.piece.at(parameter).z);
        (is_begin == is_left ? outline.end : outline.begin) = angle;
      };
      if (arc.begins_at_sheet) meets_sheet(arc.begin, true);
      if (arc.ends_at_sheet) meets_sheet(arc.end, false);
      for (Eigen::Index i = points.first[a]; i < points.first[a + 1]; ++i) {
        const double outward = points.normal_x[i] * points.x[i] + points.normal_y[i] * points.y[i];
        outline.area += (is_left ? 0.5 : -0.5) * outward * points.weight[i];
      }
      for (std::size_t b = 0; b < layout.arcs.size(); ++b) {
        if (is_taken[b] || !bounds(b) || !are_joined(arc, layout.arcs[b])) continue;
        is_taken[b] = 1;
        outline.arcs.push_back(static_cast<int>(b));
      }
    }
    out.push_back(std::move(outline));
  }
  return out;
}

bool covers(const Outline& outline, double angle) {
  return outline.sheet_ends == 2 && turn(outline.begin, angle) < turn(outline.begin, outline.end);
}

}  // namespace

std::vector<ScreenedRegion> screened_regions(const Sheet& sheet, const BorderLayout& layout,
                                             const BorderPoints& points,
                                             const Eigen::Array2Xd& electrodes,
                                             const Eigen::ArrayXd& source) {
  std::vector<ScreenedRegion> regions;
  for (Eigen::Index e = 0; e < source.size(); ++e) {
    const double ratio = 1 / source[e];
    if (ratio > 1 || !is_strong(ratio)) continue;
    const double angle = std::atan2(electrodes(1, e), electrodes(0, e));
    const Outline* around = nullptr;
    bool is_plain = true;
    const std::vector<Outline> all = outlines(sheet, layout, points, ratio);
    for (const Outline& outline : all) {
      const bool is_hole = outline.sheet_ends == 0 && outline.area < 0;
      if (is_hole || outline.sheet_ends > 2) is_plain = false;
      if (!covers(outline, angle)) continue;
      if (around) is_plain = false;
      around = &outline;
    }
    if (!around || !is_plain) continue;
    auto region = std::find_if(regions.begin(), regions.end(), [&](const ScreenedRegion& other) {
      return other.arcs == around->arcs && is_same(other.ratio, ratio);
    });
    if (region == regions.end()) {
      const ContactArc& arc = layout.arcs[static_cast<std::size_t>(around->arcs.front())];
      const double exact = is_same(arc.left, ratio) ? arc.left : arc.right;
      region = regions.insert(regions.end(), {around->arcs, {}, exact, {}});
    }
    region->electrodes.push_back(static_cast<int>(e));
  }
  return regions;
}

}  // namespace ertbench
