#include "bench/studies/localisation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ertbench {
namespace {

using Eigen::Vector2d;

FrameReading reading_at(const Vector2d& place) {
  FrameReading reading;
  reading.centroid_mm = 0.5 * place;  // a raw centroid is drawn to the middle
  reading.centroid25_mm = place;
  reading.contacts = {{place, 1, 1, 1}};
  return reading;
}

TEST(Localisation, ErrorsAreDistancesFromTheTargets) {
  const std::vector<Vector2d> places = {{10, 0}, {0, 20}};
  const std::vector<FrameReading> readings = {
      reading_at({13, 4}),  // 5 mm
      reading_at({10, 0}),  // 0 mm
      reading_at({0, 10}),  // 10 mm
      FrameReading{},
  };
  const PlaceErrors errors = place_errors(places, {0, 0, 1, 1}, readings, "test");
  const auto& thresholded = errors.rules[static_cast<std::size_t>(PlaceRule::thresholded)];
  EXPECT_NEAR(thresholded.mean->value, 5, 1e-12);
  EXPECT_NEAR(thresholded.median->value, 5, 1e-12);
  EXPECT_NEAR(thresholded.p95->value, 10, 1e-12);
  EXPECT_NEAR(*thresholded.worst, 10, 1e-12);
  EXPECT_EQ(thresholded.undefined, 1u);
  // Groups are drawn whole: the mean lies between those of the two places.
  EXPECT_GE(thresholded.mean->ci95.low, 2.5 - 1e-12);
  EXPECT_LE(thresholded.mean->ci95.high, 10 + 1e-12);
  // The mean found place of the first target is half way between its two frames.
  EXPECT_NEAR((*errors.found[0] - Vector2d(11.5, 2)).norm(), 0, 1e-12);
  EXPECT_NEAR(errors.scatter_mm[0], 2.5, 1e-12);
  const auto& raw = errors.rules[static_cast<std::size_t>(PlaceRule::raw)];
  EXPECT_NEAR(*raw.worst, (Vector2d(0, 5) - places[1]).norm(), 1e-12);
}

TEST(GroupedErrors, QuantileOfOneGroupNeedsNoInterval) {
  GroupedErrors errors(1);
  for (const double value : {3.0, 1.0, 2.0}) errors.add(0, value);
  const auto median = errors.quantile(0.5, "test");
  EXPECT_EQ(median->value, 2);
  EXPECT_EQ(median->ci95, (Interval{2, 2}));
  EXPECT_FALSE(GroupedErrors(3).mean("none"));
}

// A group without errors says nothing of them: neither that they might be nothing nor the worst.
TEST(GroupedErrors, IntervalsAreOfTheGroupsThatHaveErrors) {
  GroupedErrors errors(81);
  for (int i = 0; i < 40; ++i) errors.add(7, 2 + 0.01 * i);
  errors.add(7, 50);
  const auto mean = errors.mean("few");
  EXPECT_EQ(mean->ci95, (Interval{mean->value, mean->value}));
  const auto median = errors.quantile(0.5, "few");
  EXPECT_EQ(median->ci95, (Interval{median->value, median->value}));
}

}  // namespace
}  // namespace ertbench
