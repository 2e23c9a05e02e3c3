#pragma once

#include <string>

#include "bench/analysis/speed_accuracy.h"
#include "bench/table/table.h"

namespace ertbench {

/// What to take (within 1, 5 and 20 % of the least error, and for each budget), the right sizes,
/// and every configuration with its numbers; above them how they are to be read.
Table speed_table(const SpeedAccuracy& chart, const std::string& title);

/// What to take, for programs and pages: choice, margin or budget_us, label, the median error on
/// the test set with its interval, p50_us and p99_us; a row for every choice of the first table.
TableSection speed_choices(const SpeedAccuracy& chart);

}  // namespace ertbench
