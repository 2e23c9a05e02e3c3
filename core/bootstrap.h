#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string_view>

#include "core/interval.h"

namespace ertbench {

inline constexpr int kBootstrapResamples = 2000;

/// The percentile bootstrap's 95 % interval of the mean (Efron 1979): the 2.5 and 97.5 % quantiles
/// (interpolated_quantile) of the means of `kBootstrapResamples` resamples, each drawn with
/// replacement. With one value the interval is that value. Throws std::invalid_argument for none.
///
/// Deterministic: the random numbers are Philox's, keyed by a constant and `name`, so that the same
/// values give the same interval on every machine and in whatever order statistics are made.
Interval bootstrap_interval_of_mean(std::span<const double> values, std::string_view name);

/// The same of any statistic of values that come in groups, such as frames of the same place: whole
/// groups are drawn, as many as there are. `statistic` is given the numbers of the drawn groups,
/// 0 ... groups - 1, some of them several times. Throws std::invalid_argument for no group.
Interval bootstrap_interval_of_groups(
    std::size_t groups, const std::function<double(std::span<const std::size_t>)>& statistic,
    std::string_view name);

}  // namespace ertbench
