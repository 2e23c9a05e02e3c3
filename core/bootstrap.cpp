#include "core/bootstrap.h"

#include <Random123/philox.h>
#include <xxhash.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "core/quantile.h"

namespace ertbench {
namespace {

constexpr std::uint32_t kSeed = 0x0e27'b007;

/// Means of the resamples. Resample r takes its indices from the counters (0, r), (1, r), ...
std::vector<double> resampled_means(std::span<const double> values, std::string_view name) {
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

Interval bootstrap_interval_of_mean(std::span<const double> values, std::string_view name) {
  if (values.empty()) throw std::invalid_argument("an interval of no values was asked for");
  if (values.size() == 1) return {values[0], values[0]};
  const SortedValues means = resampled_means(values, name);
  return {interpolated_quantile(means, 0.025), interpolated_quantile(means, 0.975)};
}

}  // namespace ertbench
