#include "bench/score/frame_failure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/bench/disc_scenes.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;
using testing::true_change;
using testing::true_image;

Contact contact(Shape shape, Vector2d centre, Vector2d half_size, double angle = 0) {
  Contact out;
  out.shape = shape;
  out.centre = centre;
  out.half_size = half_size;
  out.angle = angle;
  out.conductivity_ratio = 0.5;
  return out;
}

JudgedFrame judged(const Scene& truth, const RowVectorXd& change,
                   FrameStatus status = FrameStatus::ok) {
  return judge(Sensor{}, FailureRule{}, truth, true_image(truth), change, status);
}

const Scene disc_scene = {{contact(Shape::disc, {0.3, 0.2}, {0.2, 0.2})}};

TEST(FrameFailure, APerfectImageDoesNotFail) {
  const JudgedFrame frame = judged(disc_scene, true_change(disc_scene));
  EXPECT_EQ(frame.failed, 0);
  EXPECT_NEAR(*frame.error, 0, 1e-12);
  EXPECT_EQ(*frame.distance, 0);
  EXPECT_NEAR(*frame.peak, 0.5, 1e-12);
}

TEST(FrameFailure, NothingIsAsBadAsNothing) {
  const JudgedFrame frame = judged(disc_scene, RowVectorXd::Zero(576));
  EXPECT_EQ(frame.failed, static_cast<int>(FailureKind::worse_than_nothing));
  EXPECT_EQ(*frame.error, 1);
  EXPECT_FALSE(frame.distance) << "it shows no contact that could be misplaced";
}

TEST(FrameFailure, UndefinedImages) {
  RowVectorXd change = true_change(disc_scene);
  change[7] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(judged(disc_scene, change).failed, static_cast<int>(FailureKind::undefined));
  const JudgedFrame frame = judged(disc_scene, true_change(disc_scene), FrameStatus::undefined);
  EXPECT_EQ(frame.failed, static_cast<int>(FailureKind::undefined));
  EXPECT_FALSE(frame.error || frame.peak);
}

TEST(FrameFailure, AMisplacedContact) {
  // The right contact, weakly, and a stronger one elsewhere: 0.9 + 0.2 from the true disc's border.
  const Scene both = {{contact(Shape::disc, {-0.6, 0.2}, {0.1, 0.1})}};
  const RowVectorXd change = 0.5 * true_change(disc_scene) + 1.2 * true_change(both);
  const JudgedFrame frame = judged(disc_scene, change);
  EXPECT_TRUE(frame.has(FailureKind::misplaced));
  EXPECT_NEAR(*frame.distance, 0.7, 0.02);
  EXPECT_FALSE(frame.has(FailureKind::worse_than_nothing));
  // Moved by less than an eighth of the side it counts as found.
  const Scene near_by = {{contact(Shape::disc, {0.3, 0.6}, {0.2, 0.2})}};
  const JudgedFrame close = judged(disc_scene, true_change(near_by));
  EXPECT_NEAR(*close.distance, 0.2, 0.02);
  EXPECT_FALSE(close.has(FailureKind::misplaced));
  EXPECT_TRUE(close.has(FailureKind::worse_than_nothing)) << *close.error;
}

TEST(FrameFailure, OnlyTheRegionAroundThePeakCounts) {
  // Two equal contacts, of which the image's peak belongs to one: the centroid between them would
  // be far from both.
  const Scene two = {
      {contact(Shape::disc, {-0.6, 0}, {0.2, 0.2}), contact(Shape::disc, {0.6, 0}, {0.2, 0.2})}};
  EXPECT_EQ(*judged(two, true_change(two)).distance, 0);
}

TEST(FrameFailure, BlankScenesFailByShowingAContact) {
  RowVectorXd change = RowVectorXd::Constant(576, 0.001);
  EXPECT_EQ(judged(Scene{}, change).failed, 0);
  change[100] = -0.0061;
  const JudgedFrame frame = judged(Scene{}, change);
  EXPECT_EQ(frame.failed, static_cast<int>(FailureKind::false_positive));
  EXPECT_FALSE(frame.error);
  EXPECT_NEAR(*frame.peak, 0.0061 / 0.06, 1e-12);
}

TEST(FrameFailure, DistancesToContacts) {
  const Contact circle = contact(Shape::disc, {0, 0}, {0.2, 0.2});
  EXPECT_EQ(distance_to(circle, {0.1, 0.1}), 0);
  EXPECT_NEAR(distance_to(circle, {0.3, 0.4}), 0.3, 1e-12);
  const Contact turned = contact(Shape::rectangle, {0, 0}, {0.4, 0.1}, std::numbers::pi / 2);
  EXPECT_NEAR(distance_to(turned, {0.3, 0}), 0.2, 1e-12);
  EXPECT_NEAR(distance_to(turned, {0.1 + 0.3, 0.4 + 0.4}), 0.5, 1e-12);
  const Contact ellipse = contact(Shape::ellipse, {0.1, 0}, {0.4, 0.2}, 0);
  EXPECT_NEAR(distance_to(ellipse, {0.1, 0.5}), 0.3, 1e-4);
  EXPECT_NEAR(distance_to(ellipse, {0.8, 0}), 0.3, 1e-4);
  Contact triangle;
  triangle.shape = Shape::polygon;
  triangle.vertices = {{0, 0}, {1, 0}, {0, 1}};
  EXPECT_NEAR(distance_to(triangle, {1, 1}), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(distance_to(triangle, {0.2, 0.2}), 0);
}

}  // namespace
}  // namespace ertbench
