#pragma once

#include <optional>
#include <string>

#include "bench/analysis/speed_accuracy.h"
#include "bench/score/metric_table.h"

/// Texts on charts: times and rates as people say them. Titles of axes are the metrics' own.
namespace ertbench {

/// "3.90 µs", "2.07 ms", "1.50 s", "4.9 min".
std::string time_text(double microseconds);
/// "637 k", "2.10 k", "42".
std::string rate_text(double per_second);

/// All that is known of one configuration, in lines.
std::string description(const SpeedPoint& point, const SpeedAccuracy& chart);

}  // namespace ertbench
