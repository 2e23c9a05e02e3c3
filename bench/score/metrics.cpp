#include "bench/score/metrics.h"

#include <cmath>
#include <stdexcept>

#include "bench/score/metric_formulas.h"
#include "core/text.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;

const char* unit_of(Quantity quantity) {
  if (quantity == Quantity::percent) return "%";
  if (quantity == Quantity::length) return "sheet 2 × 2";
  return quantity == Quantity::millimetres ? "mm" : "";
}

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

constexpr int probe_frames = 12;

/// Two discs that move from frame to frame.
Scene scene_of(int frame) {
  const double turn = 0.5 * frame;
  const auto disc = [](double x, double y, double radius, double ratio) {
    Contact contact;
    contact.centre = {x, y};
    contact.half_size = {radius, radius};
    contact.conductivity_ratio = ratio;
    return contact;
  };
  return {{disc(0.5 * std::cos(turn), 0.5 * std::sin(turn), 0.2 + 0.01 * frame, 0.4),
           disc(-0.45, 0.1 * std::cos(turn), 0.15, 0.7)}};
}

Eigen::RowVectorXd conductivity_of(const Scene& scene, const Sensor& sensor) {
  Eigen::VectorXd ratio(sensor.pixels());
  rasterise(scene, sensor.image(), Rasterisation::area, ratio);
  return sensor.background * ratio.transpose();
}

void add_summary(const MetricSummary& summary, std::vector<double>& out) {
  out.insert(out.end(), {summary.mean.value_or(0), summary.median.value_or(0),
                         static_cast<double>(summary.count)});
  if (summary.ci95) out.insert(out.end(), {summary.ci95->low, summary.ci95->high});
  if (summary.median_ci95) {
    out.insert(out.end(), {summary.median_ci95->low, summary.median_ci95->high});
  }
}

Probe computed() {
  const Sensor sensor;
  std::vector<FrameMetrics> scored;
  std::vector<double> contacts;
  Probe probe;
  for (int i = 0; i < probe_frames; ++i) {
    const Scene scene = scene_of(i);
    const Eigen::RowVectorXd truth = conductivity_of(scene, sensor);
    // A weaker image one frame late, with an artefact.
    Eigen::RowVectorXd change =
        0.8 * (conductivity_of(scene_of(i - 1), sensor).array() - sensor.background);
    for (Eigen::Index p = 0; p < change.size(); ++p) {
      change[p] += 0.002 * std::sin(0.3 * static_cast<double>(p) + i);
    }
    scored.push_back(frame_metrics(sensor, truth, change, scene));
    for (const FoundContact& one : contacts_of_image(sensor, ContactRule{}, change)) {
      contacts.insert(contacts.end(), {one.place.x(), one.place.y(), 100 * one.strength});
    }
  }
  const PerMetric<MetricSummary> summaries = summarise(scored);
  for (const Metric metric : kMetrics) {  // a part each, as their sizes differ
    std::vector<double> values;
    for (const FrameMetrics& one : scored) values.push_back(one[metric].value_or(0));
    add_summary(summaries[metric], values);
    probe.add(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
  }
  probe.add(Eigen::Map<const Eigen::VectorXd>(contacts.data(), std::ssize(contacts)));
  return probe;
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
  if (entry.better == Better::nearer) return std::abs(value - ideal);
  return entry.better == Better::smaller ? value - ideal : ideal - value;
}

std::string distance_title(Metric metric) {
  const MetricEntry& entry = entry_of(metric);
  const std::string ideal = entry.ideal.of_truth ? "truth" : fixed(entry.ideal.value, 0);
  if (entry.better == Better::smaller) return axis_title(metric);
  if (entry.better == Better::larger) return ideal + " − " + entry.title;
  return std::string("|") + entry.title + " − " + ideal + "|";
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

Probe score_probe() { return cached_probe("scores", computed); }

}  // namespace ertbench
