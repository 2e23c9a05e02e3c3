#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/score/metric_summary.h"

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

}  // namespace ertbench
