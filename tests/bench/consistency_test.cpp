#include "bench/studies/consistency.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

FrameReading disc_at(const Vector2d& place_mm, double radius_mm) {
  FrameReading reading;
  const double area = std::numbers::pi * radius_mm * radius_mm;
  reading.contacts.push_back({place_mm, 0.04 * area, 0.04, area});
  reading.sum = -0.04 * area;
  reading.peak = -0.04;
  reading.explained = 0.9;
  return reading;
}

/// On a circle at constant speed.
Vector2d place_of(int frame) {
  const double angle = 0.05 * frame;
  return {40 * std::cos(angle), 40 * std::sin(angle)};
}

ConsistencyScores scores_of(const std::vector<FrameReading>& moving,
                            const std::vector<FrameReading>& empty = {}) {
  MeasuredPath middle;
  for (int f = 0; f < static_cast<int>(moving.size()); ++f) middle.emplace_back(place_of(f));
  return consistency_scores({moving, empty, middle, 10}, "test");
}

TEST(Consistency, OfASteadyDiscIsPerfect) {
  std::vector<FrameReading> moving;
  for (int f = 0; f < 100; ++f) moving.push_back(disc_at(place_of(f), 15));
  const ConsistencyScores scores = scores_of(moving, std::vector<FrameReading>(20));
  EXPECT_EQ(scores.seen, 100u);
  EXPECT_NEAR(scores.radius_mm->value, 15, 1e-9);
  EXPECT_NEAR(scores.radius_spread->value, 0, 1e-9);
  EXPECT_NEAR(scores.amplitude_spread->value, 0, 1e-9);
  EXPECT_NEAR(scores.apart_mm->value, 0, 1e-9);
  // The third difference of a circle of radius r at steps of an angle a is r (2 sin(a / 2))^3, the
  // step r 2 sin(a / 2).
  EXPECT_NEAR(scores.step_mm->value, 40 * 2 * std::sin(0.025), 1e-9);
  EXPECT_NEAR(scores.jerk_mm->value, 40 * std::pow(2 * std::sin(0.025), 3), 1e-9);
  EXPECT_EQ(scores.outliers, 0u);
  EXPECT_EQ(scores.more_contacts->value, 0);
  EXPECT_NEAR(scores.explained->value, 0.9, 1e-12);
  EXPECT_EQ(scores.empty_frames, 20u);
  EXPECT_EQ(scores.false_contacts, 0u);
}

TEST(Consistency, SpreadIsTheRelativeDeviationOfNormalValues) {
  RandomStream random(5, 0, 0, Purpose::scene);
  std::vector<FrameReading> moving;
  constexpr int frames = 4000;
  for (int f = 0; f < frames; ++f) {
    moving.push_back(disc_at(place_of(f), 15 * (1 + 0.05 * random.normal())));
  }
  const ConsistencyScores scores = scores_of(moving);
  // Standard error of the range of the middle half: 1.65 of that of a standard deviation, which is
  // 0.05 / sqrt(2 frames); four of them.
  EXPECT_NEAR(scores.radius_spread->value, 0.05, 4 * 1.65 * 0.05 / std::sqrt(2.0 * frames));
  EXPECT_LT(scores.radius_spread->ci95.low, 0.05);
  EXPECT_GT(scores.radius_spread->ci95.high, 0.05);
}

TEST(Consistency, CountsWhatIsWrong) {
  std::vector<FrameReading> moving;
  for (int f = 0; f < 100; ++f) moving.push_back(disc_at(place_of(f), 15));
  moving[30].contacts.front().place_mm = {-40, -40};           // an outlier
  moving[60].contacts.push_back(moving[60].contacts.front());  // one too many
  moving[80] = FrameReading{};                                 // nothing
  std::vector<FrameReading> empty(10);
  empty[4] = disc_at({0, 0}, 5);
  const ConsistencyScores scores = scores_of(moving, empty);
  EXPECT_EQ(scores.outliers, 1u);
  EXPECT_EQ(scores.seen, 99u);
  EXPECT_NEAR(scores.more_contacts->value, 1.0 / 99, 1e-12);
  EXPECT_EQ(scores.false_contacts, 1u);
}

TEST(Consistency, TheMiddleOfSeveralPathsIgnoresOneThatIsAstray) {
  MeasuredPath right;
  for (int f = 0; f < 5; ++f) right.emplace_back(place_of(f));
  MeasuredPath astray(5, Vector2d(-90, 70));
  astray[2] = std::nullopt;
  MeasuredPath lost(5);
  const MeasuredPath three[] = {right, astray, right};
  const MeasuredPath middle = middle_path(three);
  for (std::size_t f = 0; f < 5; ++f) EXPECT_NEAR((*middle[f] - *right[f]).norm(), 0, 1e-12) << f;
  const MeasuredPath alone[] = {right, lost};
  EXPECT_FALSE(middle_path(alone)[0]) << "one method is no agreement";
}

}  // namespace
}  // namespace ertbench
