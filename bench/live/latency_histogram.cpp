#include "bench/live/latency_histogram.h"

#include <algorithm>
#include <cmath>

#include "core/quantile.h"

namespace ertbench {
namespace {

constexpr double least_latency_s = 1e-6;

}  // namespace

void LatencyHistogram::add(double seconds) {
  const double place =
      classes_per_decade * std::log10(std::max(seconds, least_latency_s) / least_latency_s);
  const auto last = static_cast<double>(counts_.size() - 1);
  ++counts_[static_cast<std::size_t>(std::min(place, last))];
  ++count_;
  largest_s_ = std::max(largest_s_, seconds);
}

std::optional<double> LatencyHistogram::quantile_s(double share) const {
  if (count_ == 0) return std::nullopt;
  const std::uint64_t rank = nearest_rank(count_, share) + 1;
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    below += counts_[i];
    if (below < rank) continue;
    const double end =
        least_latency_s * std::pow(10, static_cast<double>(i + 1) / classes_per_decade);
    return std::min(end, largest_s_);
  }
  return largest_s_;
}

std::vector<std::uint64_t> LatencyHistogram::coarse(int per_decade) const {
  const auto width = static_cast<std::size_t>(classes_per_decade / per_decade);
  std::vector<std::uint64_t> out(counts_.size() / width);
  for (std::size_t i = 0; i < counts_.size(); ++i) out[i / width] += counts_[i];
  return out;
}

}  // namespace ertbench
