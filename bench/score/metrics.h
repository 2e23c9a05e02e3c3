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
#include "core/statistics.h"
#include "forward/data/measured_frames.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

/// What is asked of the table of metrics (metric_entries.h). Tables, charts, the check, the
/// terminal, the files and the report read it and name no metric of their own accord.
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

/// The metrics whose entries fulfil a condition, in the table's order.
template <bool (*condition)(const MetricEntry&)>
constexpr auto metrics_that() {
  constexpr auto count = std::count_if(kMetricTable.begin(), kMetricTable.end(), condition);
  std::array<Metric, static_cast<std::size_t>(count)> out{};
  std::size_t i = 0;
  for (const MetricEntry& entry : kMetricTable) {
    if (condition(entry)) out[i++] = entry.metric;
  }
  return out;
}

inline constexpr auto kMetrics = metrics_that<is_metric>();
/// The paper's four.
inline constexpr auto kPublishedMetrics = metrics_that<is_published>();
/// Those of the terminal's table.
inline constexpr auto kHeadlineMetrics = metrics_that<is_headline>();
/// Those whose ideal is zero, the smaller the better: what sizes and configurations may be chosen
/// by.
inline constexpr auto kErrorMetrics = metrics_that<is_error>();

inline const char* name_of(Metric metric) { return entry_of(metric).name; }
inline int decimals_of(Metric metric) { return entry_of(metric).decimals; }

/// The inverse of name_of. Throws std::invalid_argument for another name.
Metric metric_from_name(const std::string& name);

/// The names of some metrics: those of all, of kErrorMetrics, ...
template <std::size_t Size>
std::vector<std::string> names_of(const std::array<Metric, Size>& metrics) {
  std::vector<std::string> names;
  for (const Metric metric : metrics) names.emplace_back(name_of(metric));
  return names;
}

/// The size of a value that is of no particular size: 1, or 100 of percentages and of millimetres,
/// of which half a side of the default sheet has so many.
double size_of(Quantity quantity);

/// The metric with its unit: "relative error of δσ", "RES (%)", "PE (sheet 2 × 2)".
std::string axis_title(Metric metric);

/// What a perfect image scores; `of_truth`: the mean that the true images score, where known.
/// Nothing where that is the ideal and is not known.
std::optional<double> ideal_of(Metric metric, const std::optional<double>& of_truth);

/// "ideal 1", "truth 82.78", for beside a line at `ideal`.
std::string ideal_text(Metric metric, double ideal);

/// How far `value` is from the metric's ideal, in the direction in which values become worse: the
/// smaller, the better. Where the ideal is that of the truth and is not known, its `value` stands
/// in.
double distance_from_ideal(Metric metric, double value, const std::optional<double>& of_truth);

/// What distance_from_ideal measures: "|AR − 1|", "|RES − truth|", "1 − CC", "PE (sheet 2 × 2)".
std::string distance_title(Metric metric);

/// One value for each metric.
template <typename Value>
struct PerMetric {
  std::array<Value, kMetrics.size()> values{};

  Value& operator[](Metric metric) { return values[static_cast<std::size_t>(metric)]; }
  const Value& operator[](Metric metric) const { return values[static_cast<std::size_t>(metric)]; }
};

/// The metrics of one frame; without a value where one is undefined. Default-constructed (all
/// undefined) it stands for a frame without a usable image.
using FrameMetrics = PerMetric<std::optional<double>>;

/// What was found in a frame, and how far contacts may be from the true ones.
struct FrameContacts {
  std::span<const FoundContact> found;
  ContactDistances distances;
};

/// Whether a metric can be told from what is known of a set: one of contacts needs their places,
/// any other the true images.
inline bool is_known(Metric metric, const Truth& truth) {
  return entry_of(metric).of_contacts ? truth.places : truth.images;
}

/// Compares one image, and the contacts that were found in it, with the truth.
/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// All metrics are undefined where a pixel of either image is not finite; where each of them is
/// undefined besides stands at its formula (metric_formulas.h). Throws std::invalid_argument where
/// an image has not the sensor's size.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene,
                           const FrameContacts& contacts);

/// The same with the contacts that the default rule reads out of the image, and the default
/// distances.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene);

/// That of one metric alone, where the others are not asked for.
std::optional<double> frame_metric(Metric metric, const Sensor& sensor,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const Scene& scene);

/// RES of one image of changes [pixels], %, whatever the truth (C2).
std::optional<double> resolution(const Sensor& sensor,
                                 const Eigen::Ref<const Eigen::RowVectorXd>& change);

/// A metric over the frames of a test set. Frames where it is undefined are counted and enter
/// nothing else; with no other frame there is no mean, interval or median.
struct MetricSummary {
  std::optional<double> mean;
  std::optional<Interval> ci95;  ///< of the mean
  std::optional<double> median;
  int count = 0;                             ///< frames with a value
  int undefined = 0;                         ///< frames without
  std::optional<Interval> median_ci95 = {};  ///< of the median; without a value under six frames

  bool operator==(const MetricSummary&) const = default;
};

/// Mean with bootstrap_interval_of_mean keyed by `name`, median with binomial_median_interval.
/// A value that is not finite counts as undefined. With one value the interval is that value.
MetricSummary summarise(std::span<const std::optional<double>> values, std::string_view name);

/// All metrics of all frames; those that `truth` does not tell are left empty, without a frame that
/// has a value and without one that has none.
PerMetric<MetricSummary> summarise(std::span<const FrameMetrics> frames, const Truth& truth = {});

}  // namespace ertbench
