#include "bench/score/metrics.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>

#include "bench/contacts/image_contacts.h"
#include "bench/score/contact_score.h"
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

/// `contacts`: nothing where they are to be read out of the image by the default rule.
FrameMetrics score(std::span<const Metric> wanted, const Sensor& sensor, const Image& conductivity,
                   const Image& change, const Scene& scene,
                   const std::optional<FrameContacts>& contacts) {
  require_size(sensor, conductivity, "true conductivity");
  require_size(sensor, change, "change");
  FrameMetrics metrics;
  if (!change.allFinite() || !conductivity.allFinite()) return metrics;

  const RowVectorXd truth = conductivity;
  const RowVectorXd true_change = conductivity.array() - sensor.background;
  const RowVectorXd estimated = change;
  ContactScore score_of_contacts;
  if (std::any_of(wanted.begin(), wanted.end(), [](Metric m) { return entry_of(m).of_contacts; })) {
    score_of_contacts = contacts
                            ? score_contacts(sensor, contacts->distances, scene, contacts->found)
                            : score_contacts(sensor, ContactSettings{}.distances(sensor), scene,
                                             contacts_of_image(sensor, ContactRule{}, change));
  }
  const ScoredImage image{sensor, scene, truth, true_change, estimated, score_of_contacts};
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
                           const Scene& scene, const FrameContacts& contacts) {
  return score(kMetrics, sensor, conductivity, change, scene, contacts);
}

FrameMetrics frame_metrics(const Sensor& sensor, const Image& conductivity, const Image& change,
                           const Scene& scene) {
  return score(kMetrics, sensor, conductivity, change, scene, std::nullopt);
}

std::optional<double> frame_metric(Metric metric, const Sensor& sensor, const Image& conductivity,
                                   const Image& change, const Scene& scene) {
  return score(std::span(&metric, 1), sensor, conductivity, change, scene, std::nullopt)[metric];
}

}  // namespace ertbench
