#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/score/metrics.h"

namespace ertbench {

struct BarValue {
  std::optional<double> mean;
  std::optional<Interval> ci95;  ///< drawn as a whisker
};

/// One quantity of all variants.
struct BarPanel {
  std::string title;             ///< "RES (%)"
  int decimals = 3;              ///< of the values written at the bars
  std::optional<double> ideal;   ///< drawn as a line where it is not zero
  std::string ideal_name;        ///< "ideal 1", "truth 82.78"; stands behind the title
  std::vector<BarValue> values;  ///< [variants]
};

/// Variants of a method side by side, each quantity on a scale of its own that begins at zero;
/// where all values are far from it and near to each other, as points on a scale that begins below
/// them.
struct Bars {
  std::string title;
  std::vector<std::string> labels;    ///< [variants]
  std::vector<std::string> statuses;  ///< [variants]: empty where all is well; else "failed", ...
  std::vector<BarPanel> panels;       ///< two a row; each row has a letter (a), (b), ...
};

/// Draws `stem`.svg and `stem`.png. A variant without a value keeps its place with its status.
/// Throws InputError where gnuplot is missing or a file cannot be written, std::invalid_argument
/// where sizes do not fit together.
void draw_bars(const Bars& chart, const std::filesystem::path& stem);

/// Means of several rows side by side: `{"type": "bars", "name", "solvers": [labels], "metrics",
/// "dataset"}`.
class BarChart : public Chart {
 public:
  static constexpr const char* type = "bars";

  explicit BarChart(const ChartRequest& request);
  BarChart(ChartPlace place, std::vector<std::string> labels, std::vector<Metric> metrics);

  const std::vector<std::string>& labels() const { return labels_; }
  const std::vector<Metric>& metrics() const { return metrics_; }

  /// The bars that the chart makes of the rows.
  Bars bars_of(std::span<const ResultRow> rows, const std::string& title) const;

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;

 private:
  std::vector<std::string> labels_;
  std::vector<Metric> metrics_;
};

}  // namespace ertbench
