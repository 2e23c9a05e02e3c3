#include "core/median_interval.h"

#include <cmath>
#include <numbers>

namespace ertbench {

std::optional<Interval> binomial_median_interval(const SortedValues& values) {
  // The largest k with 1 - 2 P(Binomial(count, 1/2) < k) >= .95.
  const auto count = static_cast<double>(values.size());
  std::size_t k = 0;
  double below = 0;  // P(Binomial < k + 1), once the next term is added
  while (2 * k < values.size()) {
    const auto i = static_cast<double>(k);
    below += std::exp(std::lgamma(count + 1) - std::lgamma(i + 1) - std::lgamma(count - i + 1) -
                      count * std::numbers::ln2);
    if (1 - 2 * below < 0.95) break;
    ++k;
  }
  if (k == 0) return std::nullopt;
  return Interval{values[k - 1], values[values.size() - k]};
}

}  // namespace ertbench
