#pragma once

#include <string>
#include <vector>

#include "bench/record/experiment_results.h"
#include "bench/table/table.h"
#include "core/statistics.h"

namespace ertbench {

/// The difference of the means of two labels, paired over frames, with seeds as a second level
/// (PairedBootstrap).
struct MeanDifference {
  std::string dataset;
  Metric metric = Metric::relative_error;
  std::string a;
  std::string b;
  double mean_a = 0;
  double mean_b = 0;
  Interval ci95;   ///< of mean_a - mean_b
  int frames = 0;  ///< that have the metric in every trial of every label

  /// Whether the interval leaves out 0: which of the two is the better one is then known.
  bool resolved() const { return ci95.low > 0 || ci95.high < 0; }
};

/// Labels whose pairs are all compared; of more only the best ones by each metric.
inline constexpr std::size_t most_compared_labels = 60;

/// All pairs of labels (most_compared_labels), of every metric with a column in the terminal's
/// table; where its ideal is that of the truth, of the distance from it (MetricEntry::distance). A
/// label without the metric on any frame is left out of it.
std::vector<MeanDifference> mean_differences(const ScoredLabels& scored);

/// For each metric the labels from the best to the worst: mean, difference from the next, and
/// those from which it is not resolved.
Table difference_table(const std::vector<MeanDifference>& differences);
/// A line for each pair.
TableSection difference_data(const std::vector<MeanDifference>& differences);

}  // namespace ertbench
