#include "bench/score/metrics.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/score/image_contacts.h"
#include "bench/score/metric_formulas.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

const char* unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::ratio:
      return "";
    case Quantity::percent:
      return "%";
    case Quantity::length:
      return "sheet 2 × 2";
    case Quantity::millimetres:
      return "mm";
    case Quantity::number:
      return "";
  }
  return "";
}

}  // namespace

Metric metric_from_name(const std::string& name) {
  for (const MetricEntry& entry : kMetricTable) {
    if (name == entry.name || name == first_name_of(entry.metric)) return entry.metric;
  }
  throw std::invalid_argument("no metric is called \"" + name + "\"");
}

double typical_magnitude(Quantity quantity) {
  return quantity == Quantity::percent || quantity == Quantity::millimetres ? 100 : 1;
}

std::string axis_title(Metric metric) {
  const std::string unit = unit_of(entry_of(metric).quantity);
  const std::string title = entry_of(metric).title;
  return unit.empty() ? title : title + " (" + unit + ")";
}

std::optional<double> ideal_of(Metric metric, const std::optional<double>& of_truth) {
  const Ideal& ideal = entry_of(metric).ideal;
  return ideal.of_truth ? of_truth : std::optional(ideal.value);
}

std::string ideal_text(Metric metric, double ideal) {
  if (entry_of(metric).ideal.of_truth) return "truth " + fixed(ideal, decimals_of(metric));
  return "ideal " + fixed(ideal, 0);
}

double distance_from_ideal(Metric metric, double value, const std::optional<double>& of_truth) {
  const MetricEntry& entry = entry_of(metric);
  const double ideal = ideal_of(metric, of_truth).value_or(entry.ideal.value);
  switch (entry.better) {
    case Better::smaller:
      return value - ideal;
    case Better::larger:
      return ideal - value;
    case Better::nearer:
      return std::abs(value - ideal);
  }
  return 0;
}

std::string distance_title(Metric metric) {
  const MetricEntry& entry = entry_of(metric);
  const std::string ideal = entry.ideal.of_truth ? "truth" : fixed(entry.ideal.value, 0);
  switch (entry.better) {
    case Better::smaller:
      return axis_title(metric);
    case Better::larger:
      return ideal + " − " + entry.title;
    case Better::nearer:
      return std::string("|") + entry.title + " − " + ideal + "|";
  }
  return "";
}

namespace {

using Eigen::RowVectorXd;
using Image = Eigen::Ref<const RowVectorXd>;

void require_size(const Sensor& sensor, const Image& image, const char* name) {
  if (image.size() == sensor.pixels()) return;
  throw std::invalid_argument("metrics: the " + std::string(name) + " has " +
                              std::to_string(image.size()) + " pixels, the sensor's images have " +
                              std::to_string(sensor.pixels()));
}

/// Without `contacts`, the default rule detects them in the image.
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
  if (std::ranges::any_of(wanted, [](Metric m) { return entry_of(m).of_contacts(); })) {
    score_of_contacts = contacts
                            ? score_contacts(sensor, contacts->distances, scene, contacts->found)
                            : score_contacts(sensor, ContactSettings{}.distances(sensor), scene,
                                             contacts_of_image(sensor, ContactRule{}, change));
  }
  const ScoredImage image{sensor, scene, truth, true_change, estimated, score_of_contacts};
  for (const Metric metric : wanted) {
    const std::optional<double> value = entry_of(metric).formula(image);
    // Sums of finite pixels may overflow; such a value is undefined, too.
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

MetricSummary summarise(std::span<const std::optional<double>> values, std::string_view name) {
  std::vector<double> defined;
  defined.reserve(values.size());
  for (const auto& value : values) {
    if (value && std::isfinite(*value)) defined.push_back(*value);
  }
  MetricSummary summary;
  summary.count = static_cast<int>(defined.size());
  summary.undefined = static_cast<int>(values.size() - defined.size());
  if (defined.empty()) return summary;

  summary.mean = mean(defined);
  summary.ci95 = bootstrap_interval_of_mean(defined, name);
  const SortedValues sorted(std::move(defined));
  summary.median = median(sorted);
  summary.median_ci95 = binomial_median_interval(sorted);
  return summary;
}

PerMetric<MetricSummary> summarise(std::span<const FrameMetrics> frames, const Truth& truth) {
  PerMetric<MetricSummary> summaries;
  std::vector<std::optional<double>> values(frames.size());
  for (const Metric metric : kMetrics) {
    if (!is_known(metric, truth)) continue;
    std::transform(frames.begin(), frames.end(), values.begin(),
                   [metric](const FrameMetrics& frame) { return frame[metric]; });
    summaries[metric] = summarise(values, first_name_of(metric));
  }
  return summaries;
}

}  // namespace ertbench
