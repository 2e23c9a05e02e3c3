#include "bench/score/bootstrap.h"

#define XXH_INLINE_ALL
#include <Random123/philox.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <vector>

namespace ertbench {
namespace {

constexpr std::uint32_t kSeed = 0x0e27'b007;

/// Sum of values that were each divided by the count first, so that it cannot overflow.
double mean_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  return std::accumulate(values.begin(), values.end(), 0.0,
                         [count](double sum, double value) { return sum + value / count; });
}

/// Quantile with linear interpolation between the order statistics (type 7).
double quantile(const std::vector<double>& sorted, double fraction) {
  const double place = fraction * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, sorted.size() - 1);
  const double weight = place - static_cast<double>(below);
  return (1 - weight) * sorted[below] + weight * sorted[above];
}

/// From the k-th smallest value to the k-th largest, k the largest with
/// 1 - 2 P(Binomial(count, 1/2) < k) >= .95.
std::optional<Interval> median_interval(const std::vector<double>& sorted) {
  const auto count = static_cast<double>(sorted.size());
  std::size_t k = 0;
  double below = 0;  // P(Binomial < k + 1), once the next term is added
  while (2 * k < sorted.size()) {
    const auto i = static_cast<double>(k);
    below += std::exp(std::lgamma(count + 1) - std::lgamma(i + 1) - std::lgamma(count - i + 1) -
                      count * std::numbers::ln2);
    if (1 - 2 * below < 0.95) break;
    ++k;
  }
  if (k == 0) return std::nullopt;
  return Interval{sorted[k - 1], sorted[sorted.size() - k]};
}

/// Means of the resamples. Resample r takes its indices from the counters (0, r), (1, r), ...
std::vector<double> resampled_means(const std::vector<double>& values, std::string_view name) {
  const auto hash = static_cast<std::uint32_t>(XXH64(name.data(), name.size(), 0));
  const r123::Philox4x32::key_type key = {{kSeed, hash}};
  r123::Philox4x32 philox;

  const std::uint64_t count = values.size();
  const double scale = 1 / static_cast<double>(count);
  std::vector<double> means(kBootstrapResamples);
  for (std::uint32_t resample = 0; resample < means.size(); ++resample) {
    double sum = 0;
    std::uint64_t drawn = 0;
    for (std::uint32_t block = 0; drawn < count; ++block) {
      const auto words = philox({{block, resample, 0, 0}}, key);
      for (std::size_t w = 0; w < words.size() && drawn < count; ++w, ++drawn) {
        // A 32-bit fraction of the count; off from uniform by count / 2^32 at most.
        sum += values[(words[w] * count) >> 32U] * scale;
      }
    }
    means[resample] = sum;
  }
  return means;
}

}  // namespace

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

  summary.mean = mean_of(defined);
  if (defined.size() == 1) {
    summary.ci95 = Interval{defined[0], defined[0]};
  } else {
    std::vector<double> means = resampled_means(defined, name);
    std::sort(means.begin(), means.end());
    summary.ci95 = Interval{quantile(means, 0.025), quantile(means, 0.975)};
  }
  std::sort(defined.begin(), defined.end());
  summary.median = quantile(defined, 0.5);
  summary.median_ci95 = median_interval(defined);
  return summary;
}

PerMetric<MetricSummary> summarise(std::span<const FrameMetrics> frames) {
  PerMetric<MetricSummary> summaries;
  std::vector<std::optional<double>> values(frames.size());
  for (const Metric metric : kMetrics) {
    std::transform(frames.begin(), frames.end(), values.begin(),
                   [metric](const FrameMetrics& frame) { return frame[metric]; });
    summaries[metric] = summarise(values, name_of(metric));
  }
  return summaries;
}

}  // namespace ertbench
