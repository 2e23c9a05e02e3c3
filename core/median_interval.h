#pragma once

#include <optional>

#include "core/interval.h"
#include "core/quantile.h"

namespace ertbench {

/// The 95 % interval of the median, whatever the distribution: from the k-th smallest value to the
/// k-th largest, the nearest two between which the median lies with at least 95 % by the binomial
/// distribution. None for fewer than six values.
std::optional<Interval> binomial_median_interval(const SortedValues& values);

}  // namespace ertbench
