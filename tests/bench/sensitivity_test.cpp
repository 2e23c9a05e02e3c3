#include "bench/studies/sensitivity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bench/studies/error_statistics.h"

namespace ertbench {
namespace {

const std::vector<double> kForces = {1, 2, 4};

/// Each area pressed once, up and down; the strength is a power of the force, larger in inner
/// regions, and a little more on the way back.
std::vector<PressStep> presses(const std::vector<int>& region_of, double loop) {
  std::vector<PressStep> out;
  const std::vector<double> steps = {1, 2, 4, 2, 1};
  for (std::size_t area = 0; area < region_of.size(); ++area) {
    for (std::size_t s = 0; s < steps.size(); ++s) {
      PressStep step;
      step.press = area;
      step.area = static_cast<int>(area);
      step.force_N = steps[s];
      step.rising = s < 3;
      const double strength = (1 + region_of[area]) * std::sqrt(steps[s]);
      step.peak = strength + (step.rising ? 0 : loop);
      step.sum = 100 * *step.peak;
      step.found_area = step.area;
      out.push_back(step);
    }
  }
  return out;
}

TEST(Sensitivity, CurvesAreThoseOfTheRegions) {
  const std::vector<int> region_of = area_orbits(*square_sheet(), 5);
  const auto steps = presses(region_of, 0);
  const PressResponse response = press_response(steps, steps, kForces, region_of, "test");
  const auto& peak = response.readings[0];
  ASSERT_EQ(peak.regions.size(), 6u);
  for (std::size_t region = 0; region < 6; ++region) {
    const PressResponse::Curve& curve = peak.regions[region];
    EXPECT_NEAR(curve.rising[2]->value, 2 * (1.0 + static_cast<double>(region)), 1e-12);
    EXPECT_NEAR(curve.spread, 0, 1e-12);
    EXPECT_EQ(curve.monotone->value, 1);
    EXPECT_NEAR(curve.hysteresis->value, 0, 1e-12);
  }
  // Calibrated on itself, the force is read without error.
  EXPECT_NEAR(peak.force_error->value, 0, 1e-12);
  EXPECT_NEAR(response.readings[1].force_error->value, 0, 1e-12);
}

TEST(Sensitivity, HysteresisIsTheLoopOverTheSpan) {
  const std::vector<int> region_of(1, 0);  // one area
  const auto steps = presses(region_of, 0.1);
  const PressResponse response = press_response(steps, steps, kForces, region_of, "test");
  EXPECT_NEAR(response.readings[0].regions[0].hysteresis->value, 0.1 / (2 - 1), 1e-12);
}

TEST(ForceCalibration, ReadsBackwardsBetweenTheKnots) {
  const std::vector<int> region_of(1, 0);
  std::vector<PressStep> steps(3);
  // Strengths 2, 1, 5 at forces 1, 2, 4: the first two fall and are joined at 1.5, force 1.5.
  for (std::size_t i = 0; i < 3; ++i) {
    steps[i].force_N = kForces[i];
    steps[i].peak = std::vector<double>{2, 1, 5}[i];
  }
  const ForceCalibration force(steps, Strength::peak, region_of);
  EXPECT_NEAR(*force.force_N(0, 1.5), 1.5, 1e-12);
  EXPECT_NEAR(*force.force_N(0, 3.25), 2.75, 1e-12);
  EXPECT_NEAR(*force.force_N(0, 9), 4, 1e-12);
  EXPECT_NEAR(*force.force_N(0, 0), 1.5, 1e-12);
}

}  // namespace
}  // namespace ertbench
