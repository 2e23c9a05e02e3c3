#include "bench/score/tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace ertbench {
namespace {

std::vector<TrackPoint> update(Tracker& tracker, double time_s,
                               const std::vector<Eigen::Vector2d>& places_mm) {
  return tracker.update(time_s, places_mm);
}

TEST(ConstantVelocity, OneStepByHand) {
  ConstantVelocity motion({10, -20}, 2, 30);
  motion.predict(0.1, 400);
  // P = [4 + .01 * 900, .1 * 900; ., 900] + 400^2 [.01^2 / 4, .1^3 / 2; ., .01]
  Eigen::Matrix2d predicted;
  predicted << 13 + 4, 90 + 80, 90 + 80, 900 + 1600;
  EXPECT_LT((motion.covariance() - predicted).norm(), 1e-10);

  motion.update({14, -20}, 2);
  // S = 17 + 4 = 21, K = (17, 170) / 21, P -= K (17, 170).
  Eigen::Matrix2d updated;
  updated << 17 - 17. * 17 / 21, 170 - 17. * 170 / 21, 170 - 17. * 170 / 21, 2500 - 170. * 170 / 21;
  EXPECT_LT((motion.covariance() - updated).norm(), 1e-10);
  EXPECT_NEAR(motion.place_mm().x(), 10 + 4 * 17. / 21, 1e-12);
  EXPECT_NEAR(motion.velocity_mm_s().x(), 4 * 170. / 21, 1e-12);
  EXPECT_EQ(motion.place_mm().y(), -20);
}

/// Kalata (1984): with lambda = acceleration step^2 / measurement the filter becomes an alpha-beta
/// filter, alpha = 1 - r^2 and beta = 2 (2 - alpha) - 4 sqrt(1 - alpha) of
/// r = (4 + lambda - sqrt(8 lambda + lambda^2)) / 4; the place's variance is alpha measurement^2.
TEST(ConstantVelocity, GainsBecomeKalatas) {
  for (const double lambda : {0.01, 0.1, 1.0, 10.0}) {
    const double step = 0.02;
    const double measurement = 3;
    ConstantVelocity motion({0, 0}, measurement, 500);
    for (int i = 0; i < 2000; ++i) {
      motion.predict(step, lambda * measurement / (step * step));
      motion.update({0, 0}, measurement);
    }
    motion.predict(step, lambda * measurement / (step * step));
    const Eigen::Vector2d place = motion.place_mm();
    const Eigen::Vector2d velocity = motion.velocity_mm_s();
    motion.update(place + Eigen::Vector2d(1, 0), measurement);
    const double r = (4 + lambda - std::sqrt(8 * lambda + lambda * lambda)) / 4;
    const double alpha = 1 - r * r;
    const double beta = 2 * (2 - alpha) - 4 * std::sqrt(1 - alpha);
    EXPECT_NEAR(motion.place_mm().x() - place.x(), alpha, 1e-9) << lambda;
    EXPECT_NEAR((motion.velocity_mm_s() - velocity).x() * step, beta, 1e-9) << lambda;
    EXPECT_NEAR(motion.covariance()(0, 0), alpha * measurement * measurement, 1e-8) << lambda;
  }
}

TEST(Tracker, FollowsAStraightLineExactlyOnceItKnowsTheSpeed) {
  Tracker tracker;
  const Eigen::Vector2d start(-80, 10);
  const Eigen::Vector2d velocity(400, -100);
  for (int frame = 0; frame < 90; ++frame) {
    const double t = 0.008 * frame;
    const auto points = update(tracker, t, {start + t * velocity});
    ASSERT_EQ(points.size(), 1u);
    EXPECT_EQ(points[0].id, 0);
    if (frame < 50) continue;
    EXPECT_LT((points[0].place_mm - start - t * velocity).norm(), 1e-3);
    EXPECT_LT((points[0].velocity_mm_s - velocity).norm(), 0.1);
  }
}

/// Two fingers pass each other at 3 mm; meanwhile they look like one, which is seen in their
/// middle.
TEST(Tracker, CrossingContactsKeepTheirIds) {
  for (const bool merged : {false, true}) {
    Tracker tracker;
    const Eigen::Vector2d velocity(200, 0);
    std::vector<TrackPoint> points;
    for (int frame = 0; frame <= 100; ++frame) {
      const double t = 0.008 * frame;
      const Eigen::Vector2d a = Eigen::Vector2d(-80, 1.5) + t * velocity;
      const Eigen::Vector2d b = Eigen::Vector2d(80, -1.5) - t * velocity;
      if (merged && (a - b).norm() < 10) {
        points = update(tracker, t, {(a + b) / 2});
      } else if (frame % 2 == 0) {  // the order within a frame means nothing
        points = update(tracker, t, {a, b});
      } else {
        points = update(tracker, t, {b, a});
      }
    }
    ASSERT_EQ(points.size(), 2u) << merged;
    EXPECT_EQ(points[0].id, 0);
    EXPECT_EQ(points[1].id, 1);
    EXPECT_NEAR(points[0].place_mm.x(), 80, 1) << merged;
    EXPECT_NEAR(points[1].place_mm.x(), -80, 1) << merged;
  }
}

TEST(Tracker, ANewTrackIsConfirmedInItsWindowOrForgotten) {
  Tracker tracker;  // 2 of 3 frames
  const Eigen::Vector2d here(0, 0);
  const Eigen::Vector2d there(100, 0);
  auto points = update(tracker, 0.00, {here, there});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_FALSE(points[0].confirmed || points[1].confirmed);
  points = update(tracker, 0.01, {});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_FALSE(points[0].seen);
  points = update(tracker, 0.02, {here});
  ASSERT_EQ(points.size(), 1u);  // "there" was a ghost
  EXPECT_EQ(points[0].id, 0);
  EXPECT_TRUE(points[0].confirmed);
  EXPECT_TRUE(points[0].seen);
  points = update(tracker, 0.03, {here, there});
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].id, 2);  // numbers are not used again
}

TEST(Tracker, ATrackEndsAfterItsPatience) {
  const Eigen::Vector2d here(0, 0);
  Tracker fast;  // 100 frames/s: .1 s are ten frames
  update(fast, 0, {here});
  update(fast, 0.01, {here});
  for (int frame = 2; frame <= 10; ++frame) {
    EXPECT_EQ(update(fast, 0.01 * frame, {}).size(), 1u) << frame;
  }
  EXPECT_TRUE(update(fast, 0.115, {}).empty());

  Tracker slow;  // 5 frames/s: two frames at least
  update(slow, 0, {here});
  update(slow, 0.2, {here});
  EXPECT_EQ(update(slow, 0.4, {}).size(), 1u);
  EXPECT_TRUE(update(slow, 0.6, {}).empty());
}

TEST(Tracker, WhatIsBeyondTheGateBeginsATrackOfItsOwn) {
  Tracker tracker;
  update(tracker, 0, {{0, 0}});
  EXPECT_EQ(update(tracker, 0.01, {{39, 0}}).size(), 1u);
  Tracker other;
  update(other, 0, {{0, 0}});
  EXPECT_EQ(update(other, 0.01, {{41, 0}}).size(), 2u);
}

TEST(Tracker, RefusesFramesOutOfOrder) {
  Tracker tracker;
  update(tracker, 1, {Eigen::Vector2d(0, 0)});
  EXPECT_THROW(update(tracker, 1, {}), std::invalid_argument);
}

TEST(Tracker, PlacesOfASolverBecomeMillimetresFromTheCentre) {
  FoundContact contact;
  contact.place = {0.5, -1};
  const auto places = centred_places_mm(std::vector{contact}, *square_sheet());
  EXPECT_EQ(places[0], Eigen::Vector2d(50, -100));
}

}  // namespace
}  // namespace ertbench
