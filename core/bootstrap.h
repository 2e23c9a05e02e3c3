#pragma once

#include <cstddef>
#include <functional>
#include <optional>
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

/// The sum of some values over that of others, which come in pairs: both of the same frame, say.
struct RatioOfSums {
  double ratio = 0;
  Interval ci95;  ///< by the bootstrap over the pairs
};

/// As bootstrap_interval_of_groups. `below` >= 0, as many as `above`. Nothing where `below` sums to
/// nothing; a resample of which that is so counts as the ratio itself.
std::optional<RatioOfSums> ratio_of_sums(std::span<const double> above,
                                         std::span<const double> below, std::string_view name);

}  // namespace ertbench
