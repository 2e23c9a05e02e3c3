#include "bench/score/metrics.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Image = Eigen::Ref<const RowVectorXd>;

/// Of the background; an image that nowhere exceeds it is empty. Far above the rounding of the
/// voltages, far below any contact.
constexpr double kEmpty = 1e-9;
/// Of the sum of absolute weights; a smaller sum of weights has no centroid.
constexpr double kCancelled = 1e-3;
/// Keeps a pixel that is exactly on a threshold in, whatever the rounding of its value.
constexpr double kSlack = 1e-9;

bool is_empty(const Sensor& sensor, const Image& change) {
  return change.cwiseAbs().maxCoeff() <= kEmpty * sensor.background;
}

bool cancels(const Image& weights) {
  return std::abs(weights.sum()) <= kCancelled * weights.cwiseAbs().sum();
}

/// `change` with everything under `fraction` of its largest absolute value set to zero.
RowVectorXd thresholded(const Image& change, double fraction) {
  const double limit = fraction * (1 - kSlack) * change.cwiseAbs().maxCoeff();
  return (change.array().abs() >= limit).select(change, 0.0);
}

/// Centroid of the pixel centres weighted by `change` (C4), domain units.
std::optional<Vector2d> centroid(const Sensor& sensor, const Image& change) {
  if (cancels(change)) return std::nullopt;
  const int n = sensor.image_grid;
  const RowVectorXd centres = RowVectorXd::LinSpaced(n, -1 + 1.0 / n, 1 - 1.0 / n);
  const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>
      image(change.data(), n, n);
  const double x = image.colwise().sum().dot(centres);
  const double y = image.rowwise().sum().dot(centres);
  return Vector2d(x, y) / change.sum();
}

/// Centre of gravity of a polygon's area; none where it has no area.
std::optional<Vector2d> area_centroid(const std::vector<Vector2d>& vertices) {
  double twice_area = 0;
  Vector2d moment = Vector2d::Zero();
  const Vector2d origin = vertices.empty() ? Vector2d::Zero() : vertices.front();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vector2d a = vertices[i] - origin;
    const Vector2d b = vertices[(i + 1) % vertices.size()] - origin;
    const double cross = a.x() * b.y() - a.y() * b.x();
    twice_area += cross;
    moment += cross * (a + b);
  }
  if (std::abs(twice_area) <= 1e-12) return std::nullopt;
  return Vector2d(origin + moment / (3 * twice_area));
}

std::optional<Vector2d> true_centre(const Sensor& sensor, const Scene& scene,
                                    const Image& true_change) {
  if (scene.contacts.size() == 1) {
    const Contact& contact = scene.contacts.front();
    constexpr double border = 1 + 1e-12;
    const Eigen::AlignedBox2d sheet(Vector2d(-border, -border), Vector2d(border, border));
    if (sheet.contains(contact.bounds())) {
      std::optional<Vector2d> centre = contact.shape == Shape::polygon
                                           ? area_centroid(contact.vertices)
                                           : std::optional(contact.centre);
      if (centre) return centre;
    }
  }
  return centroid(sensor, true_change);
}

std::optional<double> distance(const std::optional<Vector2d>& a, const std::optional<Vector2d>& b) {
  if (!a || !b) return std::nullopt;
  return (*a - *b).norm();
}

void require_size(const Sensor& sensor, const Image& image, const char* name) {
  if (image.size() == sensor.pixels()) return;
  throw std::invalid_argument("metrics: the " + std::string(name) + " has " +
                              std::to_string(image.size()) + " pixels, the sensor's images have " +
                              std::to_string(sensor.pixels()));
}

}  // namespace

const char* name_of(Metric metric) {
  switch (metric) {
    case Metric::AR:
      return "AR";
    case Metric::RES:
      return "RES";
    case Metric::RES_error:
      return "RES_error";
    case Metric::PE:
      return "PE";
    case Metric::PE25:
      return "PE25";
    case Metric::RIE:
      return "RIE";
    case Metric::relative_error:
      return "relative_error";
  }
  return "";
}

Metric metric_from_name(const std::string& name) {
  for (const Metric metric : kMetrics) {
    if (name == name_of(metric)) return metric;
  }
  throw std::invalid_argument("no metric is called \"" + name + "\"");
}

std::optional<double> resolution(const Sensor& sensor, const Image& change) {
  require_size(sensor, change, "change");
  if (!change.allFinite() || is_empty(sensor, change)) return std::nullopt;
  // Areas in pixels. The largest pixel always counts, so the root's argument is never negative.
  const auto bright = (thresholded(change, 0.5).array() != 0).count();
  const auto total = static_cast<double>(sensor.pixels());
  return (1 - std::sqrt(static_cast<double>(bright - 1) / total)) * 100;
}

int decimals_of(Metric metric) {
  switch (metric) {
    case Metric::AR:
    case Metric::relative_error:
      return 3;
    case Metric::RES:
    case Metric::RES_error:
      return 2;
    case Metric::PE:
    case Metric::PE25:
    case Metric::RIE:
      return 4;
  }
  return 4;
}

FrameMetrics frame_metrics(const Sensor& sensor, const Image& conductivity, const Image& change,
                           const Scene& scene) {
  require_size(sensor, conductivity, "true conductivity");
  require_size(sensor, change, "change");
  FrameMetrics metrics;
  if (!change.allFinite() || !conductivity.allFinite()) return metrics;

  const RowVectorXd true_change = conductivity.array() - sensor.background;
  metrics[Metric::RES] = resolution(sensor, change);
  metrics[Metric::RIE] = (change - true_change).norm() / conductivity.norm();
  if (!is_empty(sensor, true_change)) {
    if (!cancels(true_change)) metrics[Metric::AR] = change.sum() / true_change.sum();
    metrics[Metric::relative_error] = (change - true_change).norm() / true_change.norm();
    if (!is_empty(sensor, change)) {
      metrics[Metric::RES_error] =
          std::abs(*metrics[Metric::RES] - *resolution(sensor, true_change));
      const auto centre = true_centre(sensor, scene, true_change);
      metrics[Metric::PE] = distance(centroid(sensor, change), centre);
      metrics[Metric::PE25] = distance(centroid(sensor, thresholded(change, 0.25)), centre);
    }
  }
  for (auto& value : metrics.values) {  // finite pixels whose sums overflow
    if (value && !std::isfinite(*value)) value.reset();
  }
  return metrics;
}

}  // namespace ertbench
