#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "bench/studies/error_statistics.h"

namespace ertbench {
namespace {

TEST(SheetRegions, TheSquareHasSixOrbitsFromTheCornersToTheCentre) {
  const std::vector<int> expected = {0, 1, 2, 1, 0,  //
                                     1, 3, 4, 3, 1,  //
                                     2, 4, 5, 4, 2,  //
                                     1, 3, 4, 3, 1,  //
                                     0, 1, 2, 1, 0};
  EXPECT_EQ(area_orbits(*square_sheet()), expected);
}

TEST(SheetRegions, OrbitsHaveTheSizesOfTheSymmetries) {
  const std::vector<int> orbits = area_orbits(*square_sheet(), 5);
  std::vector<std::ptrdiff_t> sizes;
  for (int orbit = 0; orbit < 6; ++orbit) {
    sizes.push_back(std::count(orbits.begin(), orbits.end(), orbit));
  }
  EXPECT_EQ(sizes, (std::vector<std::ptrdiff_t>{4, 8, 4, 4, 4, 1}));
}

TEST(SheetRegions, ASymmetryTakesEveryPlaceIntoAnAreaOfTheSameOrbit) {
  const Sheet& sheet = *square_sheet();
  const std::vector<int> orbits = area_orbits(sheet);
  const auto orbit_of = [&](const Eigen::Vector2d& place_mm) {
    return orbits[static_cast<std::size_t>(area_of(sheet, place_mm))];
  };
  for (const Eigen::Matrix2d& symmetry : sheet.symmetries()) {
    for (const Eigen::Vector2d& place_mm :
         {Eigen::Vector2d(-85, -30), Eigen::Vector2d(13, 71), Eigen::Vector2d(50, 55)}) {
      EXPECT_EQ(orbit_of(symmetry * place_mm), orbit_of(place_mm));
    }
  }
}

TEST(SheetRegions, PlacesLieInAreasCountedFromTheLeastCorner) {
  const Sheet& sheet = *square_sheet();  // 200 mm on each side: areas of 40 mm
  EXPECT_EQ(area_of(sheet, {-99, -99}), 0);
  EXPECT_EQ(area_of(sheet, {-59, -99}), 1);
  EXPECT_EQ(area_of(sheet, {-99, -59}), 5);
  EXPECT_EQ(area_of(sheet, {0, 0}), 12);
  EXPECT_EQ(area_of(sheet, {99, 99}), 24);
  EXPECT_EQ(area_of(sheet, {1, -1}, 2), 1);
}

TEST(SheetRegions, PlacesBeyondTheSheetBelongToTheNearestArea) {
  EXPECT_EQ(area_of(*square_sheet(), {-500, 0}), 10);
  EXPECT_EQ(area_of(*square_sheet(), {100, 100}), 24);
  EXPECT_EQ(area_of(*square_sheet(), {1e300, -1e300}), 4);
}

TEST(SheetRegions, OrbitsHaveRomanNumbers) {
  EXPECT_EQ(roman(0), "I");
  EXPECT_EQ(roman(3), "IV");
  EXPECT_EQ(roman(5), "VI");
  EXPECT_EQ(roman(8), "IX");
  EXPECT_EQ(roman(48), "XLIX");
  EXPECT_THROW(roman(-1), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
