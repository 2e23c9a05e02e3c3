#include <gtest/gtest.h>

#include <cmath>

#include "bench/check/tolerance.h"
#include "bench/score/frame_failure.h"
#include "bench/score/metrics.h"
#include "forward/sheet/rasterise.h"
#include "tests/forward/disc_sheet.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;

/// Scores ask the sheet, so that a round one has its own.
class OnADisc : public ::testing::Test {
 protected:
  RowVectorXd image_of(const Scene& scene) const {
    Eigen::VectorXd ratio(sensor.pixels());
    rasterise(scene, sensor.image(), Rasterisation::area, ratio);
    return sensor.background * ratio.transpose();
  }

  static Contact disc(double x, double y, double radius) {
    Contact contact;
    contact.centre = {x, y};
    contact.half_size.setConstant(radius);
    contact.conductivity_ratio = 0.5;
    return contact;
  }

  const Sensor sensor = testing::disc_sensor();
};

TEST_F(OnADisc, ResolutionIsAShareOfThePixelsOnTheSheet) {
  const RowVectorXd truth = image_of({{disc(0, 0, 0.3)}});
  const RowVectorXd change = truth.array() - sensor.background;
  const double half = 0.5 * change.cwiseAbs().maxCoeff();
  const auto bright = static_cast<double>((change.array().abs() >= half * (1 - 1e-9)).count());
  const double pixels = sensor.image().count_on_sheet();
  ASSERT_LT(pixels, 576);
  EXPECT_NEAR(*resolution_of(sensor, change), 100 * (1 - std::sqrt((bright - 1) / pixels)), 1e-10);
}

TEST_F(OnADisc, AContactAtTheRoundBorderIsWithin) {
  // The corner of its box is 1.06 from the middle, the disc itself .9 + .1.
  const double along = 0.9 / std::sqrt(2);
  const Scene scene{{disc(along, along, 0.1)}};
  const RowVectorXd truth = image_of(scene);
  RowVectorXd change = RowVectorXd::Zero(truth.size());
  const PixelGrid pixels = sensor.image();
  const int pixel = 24 * 12 + 12;
  change[pixel] = -0.01;
  const FrameMetrics metrics = frame_metrics(sensor, truth, change, scene);
  const double expected = (pixels.centre(pixel) - Eigen::Vector2d(along, along)).norm();
  EXPECT_NEAR(*metrics[Metric::PE], expected, 1e-12);
}

TEST_F(OnADisc, TheStrongestContactIsPlacedByItsPixels) {
  const Scene scene{{disc(0.5, 0, 0.2)}};
  const RowVectorXd truth = image_of(scene);
  RowVectorXd change = RowVectorXd::Zero(truth.size());
  const PixelGrid pixels = sensor.image();
  const int pixel = 24 * 12 + 3;
  change[pixel] = -0.01;
  const JudgedFrame judged = judge(sensor, {}, scene, truth, change, FrameStatus::ok);
  EXPECT_NEAR(*judged.distance, (pixels.centre(pixel) - Eigen::Vector2d(0.5, 0)).norm() - 0.2,
              1e-12);
}

TEST_F(OnADisc, ThresholdsAreWorthAPixelOfTheDisc) {
  const double value = 80;
  BaselineMean before{Metric::RES, {&value, 1}, 10, sensor};
  const double pixels = sensor.image().count_on_sheet();
  const Tolerance exact{ToleranceClass::linear, 0};
  EXPECT_NEAR(allowed_change(exact, before), 10 / std::sqrt(pixels), 1e-9);
  // A single bright pixel may be a diameter off: 2, not the square's 2 sqrt 2.
  before.metric = Metric::PE25;
  before.resolution = 100;
  EXPECT_NEAR(allowed_change(exact, before), 2.0 / 2 / 10, 1e-9);
}

}  // namespace
}  // namespace ertbench
