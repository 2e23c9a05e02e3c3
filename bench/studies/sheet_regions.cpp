#include "bench/studies/sheet_regions.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace ertbench {
namespace {

/// The column or row of a share of the sheet's width or height.
int area_slot(double share, int areas) {
  return static_cast<int>(std::clamp(std::floor(share * areas), 0.0, areas - 1.0));
}

/// Of an area, domain units from the middle of the bounds.
Eigen::Vector2d middle_of_area(const Sheet& sheet, int area, int areas) {
  const Eigen::Vector2d share((area % areas + 0.5) / areas - 0.5,
                              (area / areas + 0.5) / areas - 0.5);
  return share.cwiseProduct(sheet.bounds().sizes());
}

}  // namespace

int area_of(const Sheet& sheet, const Eigen::Vector2d& place_mm, int areas) {
  const Eigen::Vector2d from_corner = place_mm / sheet.unit_mm() - sheet.bounds().min();
  const Eigen::Vector2d share = from_corner.cwiseQuotient(sheet.bounds().sizes());
  return area_slot(share.x(), areas) + areas * area_slot(share.y(), areas);
}

std::vector<int> area_orbits(const Sheet& sheet, int areas) {
  const int count = areas * areas;
  // The least area that each one is taken to. A symmetry that takes an area between others, as the
  // finer rotations of a disc do, joins nothing.
  std::vector<int> least(static_cast<std::size_t>(count));
  std::iota(least.begin(), least.end(), 0);
  for (const Eigen::Matrix2d& symmetry : sheet.symmetries()) {
    for (int area = 0; area < count; ++area) {
      const Eigen::Vector2d moved = symmetry * middle_of_area(sheet, area, areas);
      const Eigen::Vector2d place_mm = sheet.unit_mm() * (sheet.bounds().center() + moved);
      const int other = area_of(sheet, place_mm, areas);
      if ((middle_of_area(sheet, other, areas) - moved).norm() > 1e-9) continue;
      int& kept = least[static_cast<std::size_t>(area)];
      kept = std::min(kept, other);
    }
  }
  // How far out an area is: its ring, then its distance from the middle, both in steps of areas.
  const auto outward = [areas](int area) {
    const double x = std::abs(area % areas - (areas - 1) / 2.0);
    const double y = std::abs(area / areas - (areas - 1) / 2.0);
    return std::pair(std::max(x, y), std::hypot(x, y));
  };
  std::vector<int> firsts = least;
  std::sort(firsts.begin(), firsts.end());
  firsts.erase(std::unique(firsts.begin(), firsts.end()), firsts.end());
  std::stable_sort(firsts.begin(), firsts.end(),
                   [&](int a, int b) { return outward(a) > outward(b); });
  std::vector<int> orbits;
  for (const int area : least) {
    orbits.push_back(
        static_cast<int>(std::find(firsts.begin(), firsts.end(), area) - firsts.begin()));
  }
  return orbits;
}

std::string roman(int orbit) {
  if (orbit < 0) throw std::invalid_argument("orbits are counted from 0");
  static const std::vector<std::pair<int, const char*>> digits = {
      {1000, "M"}, {900, "CM"}, {500, "D"}, {400, "CD"}, {100, "C"}, {90, "XC"}, {50, "L"},
      {40, "XL"},  {10, "X"},   {9, "IX"},  {5, "V"},    {4, "IV"},  {1, "I"}};
  std::string out;
  int rest = orbit + 1;
  for (const auto& [value, digit] : digits) {
    for (; rest >= value; rest -= value) out += digit;
  }
  return out;
}

}  // namespace ertbench
