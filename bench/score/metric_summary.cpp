#include "bench/score/metric_summary.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/bootstrap.h"
#include "core/median_interval.h"
#include "core/moments.h"
#include "core/quantile.h"

namespace ertbench {

MetricSummary summarise(std::span<const std::optional<double>> values, std::string_view name) {
  std::vector<double> defined;
  defined.reserve(values.size());
  for (const auto& value : values) {
    if (value && std::isfinite(*value)) defined.push_back(*value);
  }
  MetricSummary summary;
  summary.count = static_cast<int>(defined.size());
  summary.undefined = static_cast<int>(values.size() - defined.size());
  if (defined.empty()) return summary;

  summary.mean = mean(defined);
  summary.ci95 = bootstrap_interval_of_mean(defined, name);
  const SortedValues sorted(std::move(defined));
  summary.median = median(sorted);
  summary.median_ci95 = binomial_median_interval(sorted);
  return summary;
}

PerMetric<MetricSummary> summarise(std::span<const FrameMetrics> frames, const Truth& truth) {
  PerMetric<MetricSummary> summaries;
  std::vector<std::optional<double>> values(frames.size());
  for (const Metric metric : kMetrics) {
    if (!is_known(metric, truth)) continue;
    std::transform(frames.begin(), frames.end(), values.begin(),
                   [metric](const FrameMetrics& frame) { return frame[metric]; });
    summaries[metric] = summarise(values, name_of(metric));
  }
  return summaries;
}

}  // namespace ertbench
