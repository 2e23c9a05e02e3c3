#include "bench/contacts/image_moments.h"

#include <cmath>

#include "core/arrays.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using ImageRow = Eigen::Ref<const RowVectorXd>;

/// Of the sum of absolute weights; a smaller sum of weights has no centroid.
constexpr double kCancelled = 1e-3;

}  // namespace

bool is_empty(const Sensor& sensor, const ImageRow& change) {
  return change.cwiseAbs().maxCoeff() <= kEmptyImage * sensor.background;
}

bool cancels(const ImageRow& weights) {
  return std::abs(weights.sum()) <= kCancelled * weights.cwiseAbs().sum();
}

RowVectorXd thresholded(const ImageRow& change, double fraction) {
  const double limit = fraction * (1 - kThresholdSlack) * change.cwiseAbs().maxCoeff();
  return (change.array().abs() >= limit).select(change, 0.0);
}

std::optional<Eigen::Vector2d> centroid(const Sensor& sensor, const ImageRow& change) {
  if (cancels(change)) return std::nullopt;
  const PixelGrid pixels = sensor.image();
  const Eigen::Map<const RowMajorMatrix> image(change.data(), pixels.rows(), pixels.columns());
  const double x = image.colwise().sum().dot(pixels.centres_x());
  const double y = image.rowwise().sum().dot(pixels.centres_y());
  return Eigen::Vector2d(x, y) / change.sum();
}

}  // namespace ertbench
