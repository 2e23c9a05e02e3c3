#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "bench/score/tracker.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {
namespace {

Polyline random_line(std::mt19937& random) {
  Polyline line(1 + random() % 5);
  for (Eigen::Vector2d& point : line) {
    point = {static_cast<double>(random() % 100), static_cast<double>(random() % 100)};
  }
  return line;
}

struct BruteForce {
  double longest_leash;
  double weighted_sum;
};

/// By all ways from (i, j) to the last points, without a table.
BruteForce all_ways(const Polyline& a, const Polyline& b, std::size_t i, std::size_t j) {
  const double here = (a[i] - b[j]).norm();
  if (i + 1 == a.size() && j + 1 == b.size()) return {here, 0};
  BruteForce best{1e300, 1e300};
  for (const auto& [di, dj] : {std::array{1u, 0u}, std::array{0u, 1u}, std::array{1u, 1u}}) {
    if (i + di >= a.size() || j + dj >= b.size()) continue;
    const BruteForce rest = all_ways(a, b, i + di, j + dj);
    const double next = (a[i + di] - b[j + dj]).norm();
    best.longest_leash = std::min(best.longest_leash, std::max(here, rest.longest_leash));
    best.weighted_sum = std::min(best.weighted_sum, (di + dj) * next + rest.weighted_sum);
  }
  return best;
}

TEST(PathDistance, IsThatOfTheBestOfAllWays) {
  std::mt19937 random(2);  // of which every platform has the same numbers
  for (int round = 0; round < 300; ++round) {
    const Polyline a = random_line(random);
    const Polyline b = random_line(random);
    const BruteForce expected = all_ways(a, b, 0, 0);
    const double sum = expected.weighted_sum + 2 * (a[0] - b[0]).norm();
    EXPECT_NEAR(frechet_distance(a, b), expected.longest_leash, 1e-12);
    EXPECT_NEAR(warped_distance(a, b), sum / static_cast<double>(a.size() + b.size()), 1e-12);
    EXPECT_NEAR(warped_distance(a, b), warped_distance(b, a), 1e-12);
  }
}

TEST(PathDistance, ByHand) {
  const Polyline straight = {{0, 0}, {1, 0}, {2, 0}};
  const Polyline above = {{0, 3}, {1, 3}, {2, 3}};
  EXPECT_DOUBLE_EQ(frechet_distance(straight, above), 3);
  EXPECT_DOUBLE_EQ(warped_distance(straight, above), 3);
  // One walker waits in the middle while the other makes a detour of 4.
  const Polyline detour = {{0, 0}, {1, 0}, {1, 4}, {1, 0}, {2, 0}};
  EXPECT_DOUBLE_EQ(frechet_distance(straight, detour), 4);
  EXPECT_DOUBLE_EQ(warped_distance(straight, detour), 4. / 8);
  // Back and forth: each point lies on the other line, but whoever went on may not come back.
  EXPECT_DOUBLE_EQ(frechet_distance({{0, 0}, {1, 0}, {0, 0}, {1, 0}}, {{0, 0}, {1, 0}}), 1);
  EXPECT_DOUBLE_EQ(frechet_distance(straight, {{1, 0}}), 1);
  EXPECT_THROW(frechet_distance({}, straight), std::invalid_argument);
}

TEST(Resampled, HasEqualStepsAlongTheLineAndBothEnds) {
  const Polyline corner = {{0, 0}, {3, 0}, {3, 0}, {3, 4}};
  EXPECT_EQ(length_of(corner), 7);
  const Polyline points = resampled(corner, 1);
  ASSERT_EQ(points.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector2d expected(std::min(i, 3), std::max(i - 3, 0));
    EXPECT_LT((points[static_cast<std::size_t>(i)] - expected).norm(), 1e-12) << i;
  }
  EXPECT_EQ(resampled(corner, 100), (Polyline{{0, 0}, {3, 4}}));
  EXPECT_EQ(resampled(corner, 5).size(), 3u);  // two steps of 3.5
  EXPECT_EQ(resampled({{1, 2}, {1, 2}}, 1), (Polyline{{1, 2}}));
  EXPECT_THROW(resampled({}, 1), std::invalid_argument);
}

TEST(Shapes, PlaceAndPenInTheAirCountForNothing) {
  const std::vector<Polyline> cross = {{{-10, 0}, {10, 0}}, {{0, 10}, {0, -10}}};
  std::vector<Polyline> moved = cross;
  for (Polyline& stroke : moved) {
    for (Eigen::Vector2d& point : stroke) point += Eigen::Vector2d(30, -7);
  }
  const Polyline shape = centred_shape(cross, 2);
  EXPECT_EQ(shape.size(), 22u);
  EXPECT_NEAR(warped_distance(shape, centred_shape(moved, 2)), 0, 1e-12);

  const std::vector<Polyline> corner = {{{-10, 10}, {-10, -10}, {10, -10}}};
  const std::vector<Polyline> shapes = {centred_shape(corner, 2), shape};
  EXPECT_EQ(nearest_shape(centred_shape(moved, 2), shapes), 1u);
  moved = corner;
  for (Eigen::Vector2d& point : moved[0]) point *= 0.8;
  EXPECT_EQ(nearest_shape(centred_shape(moved, 2), shapes), 0u);
  EXPECT_GT(warped_distance(centred_shape(moved, 2), shapes[0]), 1);
}

/// Measured: the nearest two are Z and 2, 7.5 mm apart.
TEST(Shapes, CharactersAreFarFromEachOther) {
  std::vector<Polyline> shapes;
  for (const Character& one : characters()) shapes.push_back(centred_shape(one.strokes, 3));
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GT(warped_distance(shapes[i], shapes[j]), 7)
          << characters()[i].symbol << characters()[j].symbol;
    }
  }
}

/// On a straight line at 100 mm/s the mean square is a parabola of the lag, so that the parabola's
/// vertex is exact; what lies across the line is left.
TEST(Lag, OfAStraightLineIsExact) {
  const auto truth = [](double t) -> std::optional<Eigen::Vector2d> {
    if (t < 0 || t > 2) return std::nullopt;
    return Eigen::Vector2d(100 * t, 0);
  };
  std::vector<PathPoint> tracked;
  for (int i = 0; i <= 250; ++i) {
    const double t = 0.008 * i;
    tracked.push_back({t, {100 * (t - 0.0123), i % 2 == 0 ? 3. : -3.}});
  }
  const auto fit = best_lag(tracked, truth, 0.1, 10);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->lag_s, 0.0123, 1e-9);
  EXPECT_NEAR(fit->rms_mm, 3, 1e-9);
  EXPECT_NEAR(*rms_distance(tracked, truth, 0), std::hypot(3, 1.23), 1e-9);
  EXPECT_FALSE(rms_distance(tracked, truth, 10));
  EXPECT_FALSE(best_lag(tracked, truth, 11, 10));
}

TEST(Lag, OfACircleIsFoundBetweenTheScansSteps) {
  const auto place = [](double t) {
    const double turn = 2 * std::numbers::pi * t;
    return Eigen::Vector2d(50 * std::cos(turn), 50 * std::sin(turn));
  };
  std::vector<PathPoint> tracked;
  for (int i = 0; i < 125; ++i) tracked.push_back({0.008 * i, place(0.008 * i - 0.0371)});
  const auto fit = best_lag(
      tracked, [&](double t) { return std::optional(place(t)); }, 0.1, 25);
  ASSERT_TRUE(fit);
  // The square is 2 50^2 (1 - cos 2 pi dt): next to its least a parabola but for (2 pi dt)^2 / 12,
  // a two-hundredth of a step of 4 ms at most.
  EXPECT_NEAR(fit->lag_s, 0.0371, 0.004 / 200);
  EXPECT_LT(fit->rms_mm, 0.01);
}

TEST(Lag, AtTheEndOfTheRangeIsTheEnd) {
  const auto truth = [](double t) { return std::optional<Eigen::Vector2d>({t, 0}); };
  const std::vector<PathPoint> tracked = {{1, {0, 0}}, {2, {1, 0}}};
  EXPECT_EQ(best_lag(tracked, truth, 0.5, 4)->lag_s, 0.5);
}

}  // namespace
}  // namespace ertbench
