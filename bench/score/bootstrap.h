#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "bench/score/metrics.h"

namespace ertbench {

/// A 95 % interval.
struct Interval {
  double low = 0;
  double high = 0;

  bool operator==(const Interval&) const = default;
};

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

inline constexpr int kBootstrapResamples = 2000;

/// Mean, median and the percentile bootstrap interval of the mean: the 2.5 and 97.5 % quantiles of
/// the means of `kBootstrapResamples` resamples, drawn with replacement. Deterministic: the random
/// numbers are Philox's, keyed by a constant and `name`, so that the same values give the same
/// interval on every machine and in whatever order the metrics are summarised.
/// The median's interval reaches from one of the ordered values to another, the nearest two between
/// which it lies with at least 95 % whatever the distribution (by the binomial one).
/// A value that is not finite counts as undefined. With one value the interval is that value.
MetricSummary summarise(std::span<const std::optional<double>> values, std::string_view name);

/// All metrics of all frames.
PerMetric<MetricSummary> summarise(std::span<const FrameMetrics> frames);

}  // namespace ertbench
