#pragma once

#include "bench/score/metric_formulas.h"

/// What is known of a metric: the columns of the table of metrics (metric_entries.h).
namespace ertbench {

/// What is measured on one image.
enum class Metric {
  AR,
  RES,
  RES_error,
  PE,
  PE25,
  RIE,
  relative_error,
  SSIM,
  CC,
  found,
  ghosts,
  precision,
  recall,
  location_error_mm,
  count_error,
  ospa_mm
};

/// Of what kind a metric's values are, and so how they change with the size of the sheet.
enum class Quantity {
  ratio,        ///< without a unit, about 1 in size; the same on any sheet
  percent,      ///< the same in hundredths
  length,       ///< domain units, in which the sheet is 2 x 2; grows with the sheet
  millimetres,  ///< a length on the sheet
  number,       ///< how many
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
  contact,   ///< counts contacts, or measures how far they are; a pixel may make or end one
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
  /// Of the contacts that were found (bench/contacts), not of the image itself; such metrics are a
  /// part of their own where a table is wide.
  bool of_contacts = false;
  const char* legend = "";  ///< how it is to be read, with its source; follows "heading: "
  MetricFormula* formula = nullptr;
};

}  // namespace ertbench
