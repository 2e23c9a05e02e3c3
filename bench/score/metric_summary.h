#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "bench/score/metrics.h"
#include "core/interval.h"

namespace ertbench {

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
