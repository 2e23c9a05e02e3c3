#include "bench/score/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "tests/bench/disc_scenes.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using testing::disc;
using testing::kSensor;
using testing::true_image;

RowVectorXd change_of(const RowVectorXd& conductivity) {
  return conductivity.array() - kSensor.background;
}

FrameMetrics perfect(const Scene& scene) {
  const RowVectorXd truth = true_image(scene);
  return frame_metrics(kSensor, truth, change_of(truth), scene);
}

/// The image with row and column indices moved; what leaves the sheet is lost.
RowVectorXd shifted(const RowVectorXd& image, int columns, int rows) {
  const int n = kSensor.image_grid;
  RowVectorXd out = RowVectorXd::Zero(image.size());
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const int to_row = row + rows;
      const int to_column = column + columns;
      if (to_row < 0 || to_row >= n || to_column < 0 || to_column >= n) continue;
      out[to_column + n * to_row] = image[column + n * row];
    }
  }
  return out;
}

TEST(Metrics, PerfectImageOfACentredDisc) {
  const FrameMetrics metrics = perfect({{disc(0, 0, 0.2)}});
  // The disc's radius is 2.4 pixels and its centre a corner of four: 16 pixels are covered by half
  // or more, those whose centres are nearer than (1.5, 1.5); (2.5, 0.5) is covered by a third.
  EXPECT_NEAR(metrics[Metric::RES].value(), (1 - std::sqrt(15.0 / 576)) * 100, 1e-10);
  EXPECT_NEAR(metrics[Metric::AR].value(), 1, 1e-12);
  EXPECT_NEAR(metrics[Metric::PE].value(), 0, 1e-12);
  EXPECT_NEAR(metrics[Metric::PE25].value(), 0, 1e-12);
  EXPECT_EQ(metrics[Metric::RES_error].value(), 0);
  EXPECT_EQ(metrics[Metric::RIE].value(), 0);
  EXPECT_EQ(metrics[Metric::relative_error].value(), 0);
}

TEST(Metrics, PerfectImagesOfDiscsAnywhereScoreTheDiscsArea) {
  // Over all places of the centre within a pixel the half-covered pixels are as many as the disc's
  // area on average: RES = (1 - sqrt((pi r^2 - (2/24)^2) / 4)) 100, up to the root's curvature.
  const auto mean_resolution = [](double radius) {
    double sum = 0;
    constexpr int steps = 10;
    for (int i = 0; i < steps; ++i) {
      for (int j = 0; j < steps; ++j) {
        const double x = (i + 0.5) / steps / 12;
        const double y = (j + 0.5) / steps / 12;
        sum += perfect({{disc(x, y, radius)}})[Metric::RES].value();
      }
    }
    return sum / (steps * steps);
  };
  EXPECT_NEAR(mean_resolution(0.2), 82.7, 0.2);
  EXPECT_NEAR(mean_resolution(0.4), 64.8, 0.2);  // the literal reading, r = 0.2 of a unit square
}

TEST(Metrics, EmptyImage) {
  // ||0.4 c0 inside|| / ||sigma|| of a disc with area A of 4: sqrt(.16 A / (4 - .64 A)), less what
  // the half-covered pixels at the border take.
  for (const auto& [radius, published] : {std::pair(0.2, 0.072), std::pair(0.4, 0.148)}) {
    const Scene scene{{disc(0.013, -0.027, radius)}};
    const RowVectorXd truth = true_image(scene);
    const RowVectorXd nothing = RowVectorXd::Zero(truth.size());
    const FrameMetrics metrics = frame_metrics(kSensor, truth, nothing, scene);
    const double area = std::numbers::pi * radius * radius;
    const double sharp = std::sqrt(0.16 * area / (4 - 0.64 * area));
    EXPECT_NEAR(sharp, published, 0.0005);
    EXPECT_LT(metrics[Metric::RIE].value(), sharp);
    EXPECT_GT(metrics[Metric::RIE].value(), 0.92 * sharp);
    EXPECT_EQ(metrics[Metric::AR].value(), 0);
    EXPECT_DOUBLE_EQ(metrics[Metric::relative_error].value(), 1);
    for (const Metric metric : {Metric::RES, Metric::RES_error, Metric::PE, Metric::PE25}) {
      EXPECT_FALSE(metrics[metric].has_value()) << name_of(metric);
    }
  }
}

TEST(Metrics, ShiftedImageIsOffByTheShift) {
  const Scene scene{{disc(0.1, -0.2, 0.25)}};
  const RowVectorXd truth = true_image(scene);
  const RowVectorXd change = shifted(change_of(truth), 3, -4);  // 5 pixels of 2/24
  const FrameMetrics metrics = frame_metrics(kSensor, truth, change, scene);
  const FrameMetrics unshifted = perfect(scene);
  // The pixel image's own centroid is the disc's up to what a covered pixel's fraction hides, in
  // its plain form less than half a pixel's hundredth.
  EXPECT_NEAR(metrics[Metric::PE].value(), 5.0 / 12, unshifted[Metric::PE].value() + 1e-12);
  EXPECT_LT(unshifted[Metric::PE].value(), 1e-3);
  EXPECT_EQ(metrics[Metric::RES], unshifted[Metric::RES]);
  EXPECT_NEAR(metrics[Metric::AR].value(), 1, 1e-12);
}

TEST(Metrics, RowZeroIsAtTheBottomAndColumnZeroAtTheLeft) {
  const Scene scene{{disc(0.5, 0.25, 0.1)}};
  RowVectorXd change = RowVectorXd::Zero(kSensor.pixels());
  change[0] = -0.01;  // centre (-23/24, -23/24)
  const FrameMetrics metrics = frame_metrics(kSensor, true_image(scene), change, scene);
  EXPECT_NEAR(metrics[Metric::PE].value(), std::hypot(0.5 + 23.0 / 24, 0.25 + 23.0 / 24), 1e-12);
  EXPECT_DOUBLE_EQ(metrics[Metric::RES].value(), 100);  // one pixel
}

TEST(Metrics, ScaledImageHasItsFactorAsAmplitude) {
  const Scene scene{{disc(-0.3, 0.4, 0.3)}};
  const RowVectorXd truth = true_image(scene);
  const FrameMetrics metrics = frame_metrics(kSensor, truth, 1.7 * change_of(truth), scene);
  EXPECT_NEAR(metrics[Metric::AR].value(), 1.7, 1e-12);
  EXPECT_NEAR(metrics[Metric::relative_error].value(), 0.7, 1e-12);
  EXPECT_NEAR(metrics[Metric::RIE].value(), 0.7 * change_of(truth).norm() / truth.norm(), 1e-14);
  EXPECT_EQ(metrics[Metric::RES_error].value(), 0);  // exact halves stay in, whatever the rounding
}

TEST(Metrics, ResolutionCountsPixelsOfHalfTheLargest) {
  RowVectorXd change = RowVectorXd::Zero(kSensor.pixels());
  change[10] = -2;
  change[20] = 1;       // half, of the other sign
  change[30] = 0.9999;  // less
  EXPECT_NEAR(resolution_of(kSensor, change).value(), (1 - std::sqrt(1.0 / 576)) * 100, 1e-12);
}

TEST(Metrics, ThresholdOfAQuarterDropsTheHalo) {
  const Scene scene{{disc(0, 0, 0.2)}};
  const RowVectorXd truth = true_image(scene);
  RowVectorXd change = change_of(truth);
  const double peak = change.minCoeff();
  change[5] = 0.24 * peak;
  const FrameMetrics metrics = frame_metrics(kSensor, truth, change, scene);
  // Weight of the stray pixel over all weights, times its distance from the centre.
  const double weight = 0.24 * peak / change.sum();
  const double distance = std::hypot(-1 + 11.0 / 24, -23.0 / 24);
  EXPECT_NEAR(metrics[Metric::PE].value(), weight * distance, 1e-12);
  EXPECT_LT(metrics[Metric::PE25].value(), 1e-12);
  change[5] = 0.26 * peak;
  EXPECT_GT(frame_metrics(kSensor, truth, change, scene)[Metric::PE25].value(), 1e-3);
}

TEST(Metrics, TrueCentreOfOneContactIsItsOwn) {
  // An L of three squares: its centroid is not the middle of its box, nor the mean of its corners.
  Contact polygon;
  polygon.shape = Shape::polygon;
  polygon.centre = {0.9, 0.9};  // unused for a polygon
  polygon.conductivity_ratio = 0.5;
  polygon.vertices = {{0, 0}, {0.5, 0}, {0.5, 0.25}, {0.25, 0.25}, {0.25, 0.5}, {0, 0.5}};
  const Scene scene{{polygon}};
  // All corners lie on pixel borders: the image of the truth is exact and its centroid (5, 5) / 24.
  EXPECT_NEAR(perfect(scene)[Metric::PE].value(), 0, 1e-12);
  RowVectorXd one = RowVectorXd::Zero(kSensor.pixels());
  one[14 + 24 * 14] = -1;  // centre at 5/24
  const FrameMetrics metrics = frame_metrics(kSensor, true_image(scene), one, scene);
  EXPECT_NEAR(metrics[Metric::PE].value(), 0, 1e-12);
}

TEST(Metrics, TrueCentreIsTheCentroidWhereTheContactIsCutOrNotAlone) {
  const Scene cut{{disc(0.95, 0, 0.2)}};
  const Scene two{{disc(-0.5, -0.5, 0.2, 0.3), disc(0.4, 0.6, 0.3, 0.8)}};
  for (const Scene& scene : {cut, two}) {
    EXPECT_NEAR(perfect(scene)[Metric::PE].value(), 0, 1e-12);
  }
}

TEST(Metrics, BlankTruth) {
  const Scene nothing;
  const RowVectorXd truth = true_image(nothing);
  RowVectorXd change = RowVectorXd::Zero(kSensor.pixels());
  change[7] = 0.006;
  const FrameMetrics metrics = frame_metrics(kSensor, truth, change, nothing);
  EXPECT_NEAR(metrics[Metric::RIE].value(), 0.1 / 24, 1e-14);
  EXPECT_TRUE(metrics[Metric::RES].has_value());
  for (const Metric metric :
       {Metric::AR, Metric::RES_error, Metric::PE, Metric::PE25, Metric::relative_error}) {
    EXPECT_FALSE(metrics[metric].has_value()) << name_of(metric);
  }
}

TEST(Metrics, WeightsThatCancelHaveNoCentroid) {
  const Scene scene{{disc(0, 0, 0.2)}};
  const RowVectorXd truth = true_image(scene);
  RowVectorXd change = RowVectorXd::Zero(kSensor.pixels());
  change[100] = 1e-3;
  change[200] = -1e-3;
  change[300] = 1.9e-6;  // 0.95 thousandths of the sum of absolute values
  FrameMetrics metrics = frame_metrics(kSensor, truth, change, scene);
  EXPECT_FALSE(metrics[Metric::PE].has_value());
  EXPECT_FALSE(metrics[Metric::PE25].has_value());
  EXPECT_TRUE(metrics[Metric::AR].has_value());
  EXPECT_TRUE(metrics[Metric::RES].has_value());
  change[300] = 2.1e-6;
  metrics = frame_metrics(kSensor, truth, change, scene);
  EXPECT_TRUE(metrics[Metric::PE].has_value());
  EXPECT_FALSE(metrics[Metric::PE25].has_value());
}

TEST(Metrics, NothingIsDefinedWherePixelsAreNotFinite) {
  const Scene scene{{disc(0, 0, 0.2)}};
  const RowVectorXd truth = true_image(scene);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    RowVectorXd change = change_of(truth);
    change[3] = bad;
    for (const auto& value : frame_metrics(kSensor, truth, change, scene).values) {
      EXPECT_FALSE(value.has_value());
    }
  }
  // Finite pixels, sums that are not: undefined, never infinite.
  const RowVectorXd huge = RowVectorXd::Constant(truth.size(), 1e307);
  for (const auto& value : frame_metrics(kSensor, truth, huge, scene).values) {
    EXPECT_TRUE(!value || std::isfinite(*value));
  }
}

TEST(Metrics, RefusesImagesOfAnotherSize) {
  const RowVectorXd truth = true_image({});
  EXPECT_THROW(frame_metrics(kSensor, truth, RowVectorXd::Zero(575), {}), std::invalid_argument);
  EXPECT_THROW(frame_metrics(kSensor, RowVectorXd::Zero(1), truth, {}), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
