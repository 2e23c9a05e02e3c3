#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bench/score/metric_entries.h"

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

}  // namespace ertbench
