#pragma once

#include <span>

namespace ertbench {

/// The arithmetic mean. Each value is divided by the count first, so that the sum cannot overflow.
/// Throws std::invalid_argument where there is no value.
double mean(std::span<const double> values);

/// The sample standard deviation: of n values the squares are divided by n - 1. Throws
/// std::invalid_argument where there are fewer than two values.
double sample_deviation(std::span<const double> values);

}  // namespace ertbench
