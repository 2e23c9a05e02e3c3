#include "core/bootstrap.h"

#include <Random123/philox.h>
#include <xxhash.h>

#include <cstdint>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "core/quantile.h"

namespace ertbench {
namespace {

constexpr std::uint32_t kSeed = 0x0e27'b007;

/// Calls `use(resample, index)` for the drawn indices below `count`, `count` of them for each
/// resample. Resample r takes its indices from the counters (0, r), (1, r), ...
template <typename Use>
void resample(std::uint64_t count, std::string_view name, const Use& use) {
  const auto hash = static_cast<std::uint32_t>(XXH64(name.data(), name.size(), 0));
  const r123::Philox4x32::key_type key = {{kSeed, hash}};
  r123::Philox4x32 philox;
  for (std::uint32_t r = 0; r < kBootstrapResamples; ++r) {
    std::uint64_t drawn = 0;
    for (std::uint32_t block = 0; drawn < count; ++block) {
      const auto words = philox({{block, r, 0, 0}}, key);
      for (std::size_t w = 0; w < words.size() && drawn < count; ++w, ++drawn) {
        // A 32-bit fraction of the count; off from uniform by count / 2^32 at most.
        use(r, (words[w] * count) >> 32U);
      }
    }
  }
}

std::vector<double> resampled_means(std::span<const double> values, std::string_view name) {
  const double scale = 1 / static_cast<double>(values.size());
  std::vector<double> means(kBootstrapResamples, 0);
  resample(values.size(), name,
           [&](std::uint32_t r, std::uint64_t index) { means[r] += values[index] * scale; });
  return means;
}

Interval interval_of(const SortedValues& values) {
  return {interpolated_quantile(values, 0.025), interpolated_quantile(values, 0.975)};
}

}  // namespace

Interval bootstrap_interval_of_mean(std::span<const double> values, std::string_view name) {
  if (values.empty()) throw std::invalid_argument("an interval of no values was asked for");
  if (values.size() == 1) return {values[0], values[0]};
  return interval_of(resampled_means(values, name));
}

Interval bootstrap_interval_of_groups(
    std::size_t groups, const std::function<double(std::span<const std::size_t>)>& statistic,
    std::string_view name) {
  if (groups == 0) throw std::invalid_argument("an interval of no groups was asked for");
  std::vector<std::vector<std::size_t>> drawn(kBootstrapResamples);
  resample(groups, name, [&](std::uint32_t r, std::uint64_t index) { drawn[r].push_back(index); });
  std::vector<double> values;
  for (const auto& numbers : drawn) values.push_back(statistic(numbers));
  return interval_of(std::move(values));
}

std::optional<RatioOfSums> ratio_of_sums(std::span<const double> above,
                                         std::span<const double> below, std::string_view name) {
  const double all = std::accumulate(below.begin(), below.end(), 0.0);
  if (!(all > 0)) return std::nullopt;
  RatioOfSums out;
  out.ratio = std::accumulate(above.begin(), above.end(), 0.0) / all;
  const auto of_drawn = [&](std::span<const std::size_t> drawn) {
    double over = 0;
    double under = 0;
    for (const std::size_t i : drawn) {
      over += above[i];
      under += below[i];
    }
    return under > 0 ? over / under : out.ratio;
  };
  out.ci95 = bootstrap_interval_of_groups(above.size(), of_drawn, name);
  return out;
}

}  // namespace ertbench
