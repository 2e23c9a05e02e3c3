#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bench/score/metric_formulas.h"

/// All that is known of each metric, in one table. Tables, charts, the check, the terminal, the
/// files and the report read it and name no metric of their own accord. To add a metric, write its
/// formula (metric_formulas.h), an enumerator and an entry here, and a test.
namespace ertbench {

/// What is measured on one image.
enum class Metric { AR, RES, RES_error, PE, PE25, RIE, relative_error, SSIM, CC };

/// Of what kind a metric's values are, and so how they change with the size of the sheet.
enum class Quantity {
  ratio,    ///< without a unit, about 1 in size; the same on any sheet
  percent,  ///< the same in hundredths
  length,   ///< domain units, in which the sheet is 2 x 2; grows with the sheet
};

/// Which of two values is the better.
enum class Better {
  smaller,  ///< an error: the ideal is 0, and no value is below it
  larger,   ///< the ideal is the largest value there is
  nearer,   ///< to the ideal, from either side
};

/// What a perfect image scores.
struct Ideal {
  double value = 0;
  /// The ideal is what the true images score; `value` stands in where they were not scored.
  bool of_truth = false;
};

/// By how much the value of one frame jumps where a pixel changes sides of a threshold.
enum class Threshold {
  none,      ///< no pixel is compared with a threshold
  area,      ///< counts the pixels above the threshold (C2)
  centroid,  ///< is a place to which only the pixels above the threshold contribute (D.1)
};

struct MetricEntry {
  Metric metric;
  const char* name;     ///< in files: summary.json, experiments, columns of table.csv
  const char* title;    ///< on axes and in captions, without its unit
  const char* heading;  ///< of a column, short
  Quantity quantity;
  int decimals;  ///< with which it is shown
  Ideal ideal;
  Better better;
  /// The metric that measures the distance from the ideal frame by frame, for which the distance of
  /// the means is no substitute; itself where there is none.
  Metric distance;
  Threshold threshold;  ///< how far a mean may lie from that of another build (the check)
  bool published;       ///< one of the paper's four, which its tables give
  bool headline;        ///< has a column in the terminal's table
  const char* legend;   ///< how it is to be read, with its source; follows "heading: "
  MetricFormula* formula;
};

inline constexpr auto kMetricTable = std::to_array<MetricEntry>({
    {.metric = Metric::AR,
     .name = "AR",
     .title = "AR",
     .heading = "AR",
     .quantity = Quantity::ratio,
     .decimals = 3,
     .ideal = {1},
     .better = Better::nearer,
     .distance = Metric::AR,
     .threshold = Threshold::none,
     .published = true,
     .headline = true,
     .legend = "sum of δσ of the image over that of the truth (C1); ideal 1.",
     .formula = amplitude_response},
    {.metric = Metric::RES,
     .name = "RES",
     .title = "RES",
     .heading = "RES (%)",
     .quantity = Quantity::percent,
     .decimals = 2,
     .ideal = {100, true},
     .better = Better::nearer,
     .distance = Metric::RES_error,
     .threshold = Threshold::area,
     .published = true,
     .headline = true,
     .legend = "(1 − √((A50 − Apixel)/Atotal))·100, A50 the area where |δσ| is at least half its "
               "maximum (C2); ideal is the RES of the true images, not 100.",
     .formula = image_resolution},
    {.metric = Metric::RES_error,
     .name = "RES_error",
     .title = "|RES − truth|",
     .heading = "|RES − truth|",
     .quantity = Quantity::percent,
     .decimals = 2,
     .ideal = {0},
     .better = Better::smaller,
     .distance = Metric::RES_error,
     .threshold = Threshold::area,
     .published = false,
     .headline = false,
     .legend = "mean distance of a frame's RES from that of its true image; ideal 0.",
     .formula = resolution_error},
    {.metric = Metric::PE,
     .name = "PE",
     .title = "PE",
     .heading = "PE",
     .quantity = Quantity::length,
     .decimals = 4,
     .ideal = {0},
     .better = Better::smaller,
     .distance = Metric::PE,
     .threshold = Threshold::none,
     .published = true,
     .headline = true,
     .legend = "distance of the centroid of δσ from the true centre, in units in which the sheet "
               "is 2 × 2 (C3, C4); ideal 0.",
     .formula = position_error},
    {.metric = Metric::PE25,
     .name = "PE25",
     .title = "PE25",
     .heading = "PE25",
     .quantity = Quantity::length,
     .decimals = 4,
     .ideal = {0},
     .better = Better::smaller,
     .distance = Metric::PE25,
     .threshold = Threshold::centroid,
     .published = false,
     .headline = false,
     .legend = "PE after whatever is under 25 % of the largest |δσ| is set to zero (D.1); ideal 0.",
     .formula = position_error_of_the_peak},
    {.metric = Metric::RIE,
     .name = "RIE",
     .title = "RIE",
     .heading = "RIE",
     .quantity = Quantity::ratio,
     .decimals = 4,
     .ideal = {0},
     .better = Better::smaller,
     .distance = Metric::RIE,
     .threshold = Threshold::none,
     .published = true,
     .headline = true,
     .legend = "‖σ of the image − σ‖ / ‖σ‖ (C5); ideal 0, to be read against the row no-contact, "
               "the image in which nothing happens.",
     .formula = relative_image_error},
    {.metric = Metric::relative_error,
     .name = "relative_error",
     .title = "relative error of δσ",
     .heading = "rel. error δσ",
     .quantity = Quantity::ratio,
     .decimals = 3,
     .ideal = {0},
     .better = Better::smaller,
     .distance = Metric::relative_error,
     .threshold = Threshold::none,
     .published = false,
     .headline = true,
     .legend = "‖δσ of the image − δσ‖ / ‖δσ‖; ideal 0, no-contact has 1.",
     .formula = relative_error_of_change},
    {.metric = Metric::SSIM,
     .name = "SSIM",
     .title = "SSIM of δσ",
     .heading = "SSIM",
     .quantity = Quantity::ratio,
     .decimals = 3,
     .ideal = {1},
     .better = Better::larger,
     .distance = Metric::SSIM,
     .threshold = Threshold::none,
     .published = false,
     .headline = false,
     .legend = "structural similarity of δσ of the image and δσ, the mean over all pixels of "
               "windows of 11 × 11 pixels (Wang et al. 2004), the span of δσ as dynamic range; "
               "ideal 1, to be read against the row no-contact, whose windows without a contact "
               "score 1.",
     .formula = structural_similarity},
    {.metric = Metric::CC,
     .name = "CC",
     .title = "CC of δσ",
     .heading = "CC",
     .quantity = Quantity::ratio,
     .decimals = 3,
     .ideal = {1},
     .better = Better::larger,
     .distance = Metric::CC,
     .threshold = Threshold::none,
     .published = false,
     .headline = false,
     .legend = "Pearson's correlation coefficient of δσ of the image and δσ over the pixels, "
               "whatever their scales and offsets; ideal 1.",
     .formula = correlation_coefficient},
});

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

/// The size of a value that is of no particular size: 1, or 100 of percentages.
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
