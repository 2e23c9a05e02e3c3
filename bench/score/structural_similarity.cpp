#include <Eigen/Core>
#include <cmath>

#include "bench/score/metric_formulas.h"
#include "bench/score/scored_image.h"

namespace ertbench {
namespace {

using Eigen::ArrayXXd;
using Eigen::MatrixXd;

constexpr int kReach = 5;  ///< pixels from the middle of a window to its edge
constexpr double kDeviation = 1.5;

/// Row i holds the weights of the window around pixel i of a line of n pixels: a Gaussian, cut at
/// the ends of the line, with sum 1. The window of an image is the product of two of these.
MatrixXd window_weights(int n) {
  MatrixXd weights = MatrixXd::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = std::max(0, i - kReach); j <= std::min(n - 1, i + kReach); ++j) {
      const double distance = (j - i) / kDeviation;
      weights(i, j) = std::exp(-distance * distance / 2);
    }
    weights.row(i) /= weights.row(i).sum();
  }
  return weights;
}

}  // namespace

std::optional<double> structural_similarity(const ScoredImage& image) {
  if (image.truth_is_empty()) return std::nullopt;
  const PixelGrid pixels = image.sensor.image();
  const double range =
      std::max(image.true_change.maxCoeff(), 0.0) - std::min(image.true_change.minCoeff(), 0.0);
  const double c1 = 0.01 * 0.01;
  const double c2 = 0.03 * 0.03;
  // Both in units of the dynamic range, which is 1 from here on.
  const ArrayXXd x =
      Eigen::Map<const ArrayXXd>(image.change.data(), pixels.columns(), pixels.rows()) / range;
  const ArrayXXd y =
      Eigen::Map<const ArrayXXd>(image.true_change.data(), pixels.columns(), pixels.rows()) / range;

  // Column-major: a pixel's column is the first index.
  const MatrixXd across = window_weights(pixels.columns());
  const MatrixXd along = window_weights(pixels.rows());
  const auto averaged = [&](const ArrayXXd& values) -> ArrayXXd {
    return (across * values.matrix() * along.transpose()).array();
  };
  const ArrayXXd mean_x = averaged(x);
  const ArrayXXd mean_y = averaged(y);
  const ArrayXXd variances = averaged(x.square() + y.square()) - mean_x.square() - mean_y.square();
  const ArrayXXd covariance = averaged(x * y) - mean_x * mean_y;
  const ArrayXXd similarity = (2 * mean_x * mean_y + c1) * (2 * covariance + c2) /
                              ((mean_x.square() + mean_y.square() + c1) * (variances + c2));
  if (pixels.all_on_sheet()) return similarity.mean();
  double sum = 0;
  for (int p = 0; p < pixels.count(); ++p) {
    if (pixels.on_sheet(p)) sum += similarity.data()[p];
  }
  return sum / pixels.count_on_sheet();
}

}  // namespace ertbench
