#include "core/quantile.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace ertbench {
namespace {

void check(std::size_t count, double share) {
  if (count == 0) throw std::invalid_argument("a quantile of no values was asked for");
  if (!(share >= 0 && share <= 1)) {
    throw std::invalid_argument("the share of a quantile must be within 0 ... 1");
  }
}

}  // namespace

SortedValues::SortedValues(std::vector<double> values) : values_(std::move(values)) {
  std::sort(values_.begin(), values_.end());
}

double interpolated_quantile(const SortedValues& values, double share) {
  check(values.size(), share);
  const double place = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, values.size() - 1);
  const double weight = place - static_cast<double>(below);
  return (1 - weight) * values[below] + weight * values[above];
}

std::size_t nearest_rank(std::size_t count, double share) {
  check(count, share);
  const double rank = std::ceil(share * static_cast<double>(count));  // from 1
  return static_cast<std::size_t>(std::max(1.0, rank)) - 1;
}

double nearest_rank_quantile(const SortedValues& values, double share) {
  return values[nearest_rank(values.size(), share)];
}

double median(const SortedValues& values) { return interpolated_quantile(values, 0.5); }

double upper_median(const SortedValues& values) {
  return values[values.size() - 1 - nearest_rank(values.size(), 0.5)];
}

}  // namespace ertbench
