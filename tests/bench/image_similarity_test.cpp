// Structural similarity and the correlation coefficient, against plain loops over their definitions
// and against cases that can be worked out by hand.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/score/metrics.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;

const Sensor kSquare;
const int kGrid = kSquare.image_grid;

/// One metric of `change` where the truth is `true_change` [pixels] S/m.
std::optional<double> score(Metric metric, const RowVectorXd& true_change,
                            const RowVectorXd& change) {
  const RowVectorXd conductivity = true_change.array() + kSquare.background;
  return frame_metrics(kSquare, conductivity, change, Scene{})[metric];
}

/// Smooth waves, other ones for every `phase`; S/m.
RowVectorXd waves(double phase) {
  RowVectorXd image(kGrid * kGrid);
  for (int row = 0; row < kGrid; ++row) {
    for (int column = 0; column < kGrid; ++column) {
      image[row * kGrid + column] =
          0.02 * std::sin(0.31 * column + phase) * std::cos(0.47 * row - 2 * phase) - 0.01;
    }
  }
  return image;
}

/// One contact of 4 x 6 pixels at the left border.
RowVectorXd contact() {
  RowVectorXd image = RowVectorXd::Zero(kGrid * kGrid);
  for (int row = 3; row < 9; ++row) image.segment(row * kGrid, 4).setConstant(-0.03);
  return image;
}

/// The definition, pixel by pixel and window by window.
double plain_similarity(const RowVectorXd& truth, const RowVectorXd& image) {
  double high = 0;
  double low = 0;
  for (const double value : truth) {
    high = std::max(high, value);
    low = std::min(low, value);
  }
  const double c1 = std::pow(0.01 * (high - low), 2);
  const double c2 = std::pow(0.03 * (high - low), 2);
  double sum = 0;
  for (int row = 0; row < kGrid; ++row) {
    for (int column = 0; column < kGrid; ++column) {
      double weights = 0, mean_x = 0, mean_y = 0;
      const auto for_window = [&](const auto& visit) {
        for (int r = row - 5; r <= row + 5; ++r) {
          for (int c = column - 5; c <= column + 5; ++c) {
            if (r < 0 || r >= kGrid || c < 0 || c >= kGrid) continue;
            const double square = (r - row) * (r - row) + (c - column) * (c - column);
            visit(std::exp(-square / (2 * 1.5 * 1.5)), image[r * kGrid + c], truth[r * kGrid + c]);
          }
        }
      };
      for_window([&](double w, double x, double y) {
        weights += w;
        mean_x += w * x;
        mean_y += w * y;
      });
      mean_x /= weights;
      mean_y /= weights;
      double var_x = 0, var_y = 0, covariance = 0;
      for_window([&](double w, double x, double y) {
        var_x += w / weights * (x - mean_x) * (x - mean_x);
        var_y += w / weights * (y - mean_y) * (y - mean_y);
        covariance += w / weights * (x - mean_x) * (y - mean_y);
      });
      sum += (2 * mean_x * mean_y + c1) * (2 * covariance + c2) /
             ((mean_x * mean_x + mean_y * mean_y + c1) * (var_x + var_y + c2));
    }
  }
  return sum / (kGrid * kGrid);
}

TEST(StructuralSimilarity, IsThatOfItsDefinition) {
  for (const double phase : {0.0, 0.4, 1.9}) {
    EXPECT_NEAR(score(Metric::SSIM, waves(0), waves(phase)).value(),
                plain_similarity(waves(0), waves(phase)), 1e-12);
  }
  const RowVectorXd blurred = 0.6 * contact() + 0.1 * waves(1);
  const double similarity = score(Metric::SSIM, contact(), blurred).value();
  EXPECT_NEAR(similarity, plain_similarity(contact(), blurred), 1e-12);
  EXPECT_GT(similarity, 0.1);  // neither of the trivial values
  EXPECT_LT(similarity, 0.99);
}

TEST(StructuralSimilarity, OfTheTruthIsOne) {
  EXPECT_NEAR(score(Metric::SSIM, contact(), contact()).value(), 1, 1e-13);
  EXPECT_NEAR(score(Metric::SSIM, waves(0), waves(0)).value(), 1, 1e-13);
  // Not so where a contact's sign is wrong, but for the windows without one.
  const double reversed = score(Metric::SSIM, contact(), -contact()).value();
  EXPECT_NEAR(reversed, plain_similarity(contact(), -contact()), 1e-12);
  EXPECT_LT(reversed, 0.95);
}

TEST(StructuralSimilarity, OfConstantImagesIsTheTermOfTheirMeans) {
  // No variance: (2 a b + C1) / (a^2 + b^2 + C1), and L = |a| of the truth.
  for (const auto& [a, b] : {std::pair(-0.02, -0.01), std::pair(-0.02, 0.01), std::pair(0.03, 0.03),
                             std::pair(0.03, 0.0)}) {
    const double c1 = 1e-4 * a * a;
    EXPECT_NEAR(score(Metric::SSIM, RowVectorXd::Constant(kGrid * kGrid, a),
                      RowVectorXd::Constant(kGrid * kGrid, b))
                    .value(),
                (2 * a * b + c1) / (a * a + b * b + c1), 1e-9);
  }
}

TEST(StructuralSimilarity, KnowsNoUnit) {
  const RowVectorXd image = 0.6 * contact() + 0.1 * waves(1);
  const double similarity = score(Metric::SSIM, contact(), image).value();
  EXPECT_NEAR(score(Metric::SSIM, 1e-3 * contact(), 1e-3 * image).value(), similarity, 1e-9);
}

TEST(StructuralSimilarity, NeedsATruthThatIsNotEmpty) {
  const RowVectorXd nothing = RowVectorXd::Zero(kGrid * kGrid);
  EXPECT_FALSE(score(Metric::SSIM, nothing, contact()));
  // Where the image is empty the windows without a contact are right and those with one are not.
  const double similarity = score(Metric::SSIM, contact(), nothing).value();
  EXPECT_NEAR(similarity, plain_similarity(contact(), nothing), 1e-12);
  EXPECT_LT(similarity, 0.95);
  EXPECT_GT(similarity, 0.5);
}

/// The definition as a sum over all pairs of pixels, without means.
double plain_correlation(const RowVectorXd& a, const RowVectorXd& b) {
  double ab = 0, aa = 0, bb = 0;
  for (int i = 0; i < a.size(); ++i) {
    for (int j = 0; j < i; ++j) {
      ab += (a[i] - a[j]) * (b[i] - b[j]);
      aa += (a[i] - a[j]) * (a[i] - a[j]);
      bb += (b[i] - b[j]) * (b[i] - b[j]);
    }
  }
  return ab / std::sqrt(aa * bb);
}

TEST(CorrelationCoefficient, IsThatOfItsDefinition) {
  for (const double phase : {0.1, 0.4, 1.9}) {
    const double correlation = score(Metric::CC, waves(0), waves(phase)).value();
    EXPECT_NEAR(correlation, plain_correlation(waves(0), waves(phase)), 1e-12);
    EXPECT_LT(std::abs(correlation), 0.999);
  }
}

TEST(CorrelationCoefficient, IsOneWhateverScaleAndOffset) {
  EXPECT_NEAR(score(Metric::CC, contact(), contact()).value(), 1, 1e-13);
  EXPECT_NEAR(score(Metric::CC, contact(), -contact()).value(), -1, 1e-13);
  const RowVectorXd moved = 3.5 * contact().array() + 0.2;
  EXPECT_NEAR(score(Metric::CC, contact(), moved).value(), 1, 1e-12);
}

TEST(CorrelationCoefficient, OfTwoPatches) {
  // n of N pixels are 1 in both images and m in one of them only:
  // (n N - n (n + m)) / sqrt(n (N - n) (n + m) (N - n - m)).
  const double N = kGrid * kGrid, n = 24, m = 40;
  RowVectorXd small = RowVectorXd::Zero(kGrid * kGrid);
  RowVectorXd large = small;
  small.head(24).setConstant(-0.01);
  large.head(64).setConstant(-0.02);
  EXPECT_NEAR(score(Metric::CC, small, large).value(),
              (n * N - n * (n + m)) / std::sqrt(n * (N - n) * (n + m) * (N - n - m)), 1e-13);
}

TEST(CorrelationCoefficient, NeedsTwoImagesThatAreNotConstant) {
  const RowVectorXd constant = RowVectorXd::Constant(kGrid * kGrid, -0.01);
  EXPECT_FALSE(score(Metric::CC, contact(), constant));
  EXPECT_FALSE(score(Metric::CC, constant, contact()));
  EXPECT_FALSE(score(Metric::CC, contact(), 0 * constant));
}

}  // namespace
}  // namespace ertbench
