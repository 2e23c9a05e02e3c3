#include "bench/score/metrics.h"

#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

#include "bench/score/scored_image.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Image = Eigen::Ref<const RowVectorXd>;

void require_size(const Sensor& sensor, const Image& image, const char* name) {
  if (image.size() == sensor.pixels()) return;
  throw std::invalid_argument("metrics: the " + std::string(name) + " has " +
                              std::to_string(image.size()) + " pixels, the sensor's images have " +
                              std::to_string(sensor.pixels()));
}

FrameMetrics score(std::span<const Metric> wanted, const Sensor& sensor, const Image& conductivity,
                   const Image& change, const Scene& scene) {
  require_size(sensor, conductivity, "true conductivity");
  require_size(sensor, change, "change");
  FrameMetrics metrics;
  if (!change.allFinite() || !conductivity.allFinite()) return metrics;

  const RowVectorXd truth = conductivity;
  const RowVectorXd true_change = conductivity.array() - sensor.background;
  const RowVectorXd estimated = change;
  const ScoredImage image{sensor, scene, truth, true_change, estimated};
  for (const Metric metric : wanted) {
    const std::optional<double> value = entry_of(metric).formula(image);
    // Sums of finite pixels may overflow: such a value is undefined, too.
    if (value && std::isfinite(*value)) metrics[metric] = value;
  }
  return metrics;
}

}  // namespace

std::optional<double> resolution(const Sensor& sensor, const Image& change) {
  require_size(sensor, change, "change");
  if (!change.allFinite()) return std::nullopt;
  return resolution_of(sensor, change);
}

FrameMetrics frame_metrics(const Sensor& sensor, const Image& conductivity, const Image& change,
                           const Scene& scene) {
  return score(kMetrics, sensor, conductivity, change, scene);
}

std::optional<double> frame_metric(Metric metric, const Sensor& sensor, const Image& conductivity,
                                   const Image& change, const Scene& scene) {
  return score(std::span(&metric, 1), sensor, conductivity, change, scene)[metric];
}

}  // namespace ertbench
