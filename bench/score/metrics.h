#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/score/image_contacts.h"
#include "bench/score/metric_entries.h"
#include "core/probe.h"
#include "core/statistics.h"
#include "forward/data/measured_frames.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

/// Queries of the table of metrics (metric_entries.h), and the metrics of frames and of test sets.
/// Tables, charts, the check, the terminal and the files go through the table; none of them names a
/// metric itself.
namespace ertbench {

static_assert(
    [] {
      for (std::size_t i = 0; i < kMetricTable.size(); ++i) {
        if (kMetricTable[i].metric != static_cast<Metric>(i)) return false;
      }
      return true;
    }(),
    "the table's entries stand in the order of the enumerators");

constexpr const MetricEntry& entry_of(Metric metric) {
  return kMetricTable[static_cast<std::size_t>(metric)];
}

constexpr bool is_metric(const MetricEntry& /*any*/) { return true; }
constexpr bool is_published(const MetricEntry& entry) { return entry.published; }
constexpr bool is_headline(const MetricEntry& entry) { return entry.headline; }
constexpr bool is_error(const MetricEntry& entry) { return entry.better == Better::smaller; }

/// Metrics whose entries fulfil a condition, in the table's order.
template <bool (*condition)(const MetricEntry&)>
constexpr auto metrics_that() {
  constexpr auto count = std::ranges::count_if(kMetricTable, condition);
  std::array<Metric, static_cast<std::size_t>(count)> out{};
  std::size_t i = 0;
  for (const MetricEntry& entry : kMetricTable) {
    if (condition(entry)) out[i++] = entry.metric;
  }
  return out;
}

inline constexpr auto kMetrics = metrics_that<is_metric>();
/// The four metrics of the paper.
inline constexpr auto kPublishedMetrics = metrics_that<is_published>();
/// Columns of the terminal's table.
inline constexpr auto kHeadlineMetrics = metrics_that<is_headline>();
/// Metrics with the ideal 0 of which smaller is better; sizes and configurations are chosen by one
/// of them.
inline constexpr auto kErrorMetrics = metrics_that<is_error>();

inline const char* name_of(Metric metric) { return entry_of(metric).name; }
inline int decimals_of(Metric metric) { return entry_of(metric).decimals; }

/// The name under which the metric was first published. It keys bootstrap samples and records, so
/// that a renamed metric keeps its intervals to the last digit and its cached records.
inline const char* first_name_of(Metric metric) {
  const MetricEntry& entry = entry_of(metric);
  return entry.former_name != nullptr ? entry.former_name : entry.name;
}

/// Takes the name of a metric or its former name. Throws std::invalid_argument for any other.
Metric metric_from_name(const std::string& name);

/// The key that a file has for the metric: its name or, in files of earlier releases, its former
/// name; nullptr if the file has neither. `has(key)` tells whether a key is there.
template <typename Has>
const char* key_in_file(Metric metric, Has has) {
  for (const char* key : {name_of(metric), first_name_of(metric)}) {
    if (has(key)) return key;
  }
  return nullptr;
}

template <std::size_t Size>
std::vector<std::string> names_of(const std::array<Metric, Size>& metrics) {
  std::vector<std::string> names;
  for (const Metric metric : metrics) names.emplace_back(name_of(metric));
  return names;
}

/// The names that an experiment may call these metrics by, former names last.
template <std::size_t Size>
std::vector<std::string> accepted_names(const std::array<Metric, Size>& metrics) {
  std::vector<std::string> names = names_of(metrics);
  for (const Metric metric : metrics) {
    if (first_name_of(metric) != name_of(metric)) names.emplace_back(first_name_of(metric));
  }
  return names;
}

/// Scale of typical values: 100 for percentages and millimetres (half a side of the default sheet),
/// else 1.
double typical_magnitude(Quantity quantity);

/// The metric with its unit: "relative error of δσ", "RES (%)", "PE (sheet 2 × 2)".
std::string axis_title(Metric metric);

/// The score of a perfect image. `of_truth` is the mean score of the true images; without it,
/// metrics whose ideal that is have none.
std::optional<double> ideal_of(Metric metric, const std::optional<double>& of_truth);

/// Label of a line at `ideal`: "ideal 1", "truth 82.78".
std::string ideal_text(Metric metric, double ideal);

/// Distance of `value` from the metric's ideal in the direction of worse values; smaller is better.
/// If the ideal is the truth's score and `of_truth` is unknown, Ideal::value stands in.
double distance_from_ideal(Metric metric, double value, const std::optional<double>& of_truth);

/// Title of distance_from_ideal: "|AR − 1|", "|RES − truth|", "1 − CC", "PE (sheet 2 × 2)".
std::string distance_title(Metric metric);

/// One value for each metric.
template <typename Value>
struct PerMetric {
  std::array<Value, kMetrics.size()> values{};

  Value& operator[](Metric metric) { return values[static_cast<std::size_t>(metric)]; }
  const Value& operator[](Metric metric) const { return values[static_cast<std::size_t>(metric)]; }
};

/// Metrics of one frame; an undefined metric has no value. Default-constructed (all undefined) it
/// stands for a frame without a usable image.
using FrameMetrics = PerMetric<std::optional<double>>;

/// Contacts detected in a frame, and the distances by which they are scored.
struct FrameContacts {
  std::span<const FoundContact> found;
  ContactDistances distances;
};

/// True if the known truth of a set suffices for a metric: those of contacts need the contact
/// positions, all others the true images.
inline bool is_known(Metric metric, const Truth& truth) {
  return entry_of(metric).of_contacts() ? truth.places : truth.images;
}

/// Compares one image, and the contacts detected in it, with the truth.
/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// All metrics are undefined if a pixel of either image is not finite; further conditions stand at
/// each formula (metric_formulas.h). Throws std::invalid_argument for images of another size than
/// the sensor's.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene,
                           const FrameContacts& contacts);

/// As above, with the contacts that the default rule detects in the image, and default distances.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene);

/// As above, for one metric; the others are not computed.
std::optional<double> frame_metric(Metric metric, const Sensor& sensor,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const Scene& scene);

/// A metric over the frames of a test set. Frames in which it is undefined are only counted; if it
/// is undefined in all of them there is no mean, interval or median.
struct MetricSummary {
  std::optional<double> mean;
  std::optional<Interval> ci95;  ///< of the mean
  std::optional<double> median;
  int count = 0;                             ///< frames with a value
  int undefined = 0;                         ///< frames without a value
  std::optional<Interval> median_ci95 = {};  ///< of the median; needs six frames

  bool operator==(const MetricSummary&) const = default;
};

/// Mean with bootstrap_interval_of_mean keyed by `name` (first_name_of for a metric), median with
/// binomial_median_interval. A value that is not finite counts as undefined. The interval of a
/// single value is that value.
MetricSummary summarise(std::span<const std::optional<double>> values, std::string_view name);

/// Summaries of all metrics. Those for which the known truth does not suffice stay empty: both
/// counts are 0.
PerMetric<MetricSummary> summarise(std::span<const FrameMetrics> frames, const Truth& truth = {});

/// The probe "scores": metrics of fixed images, their summaries, and the contacts that are read out
/// of the images.
Probe score_probe();

}  // namespace ertbench
