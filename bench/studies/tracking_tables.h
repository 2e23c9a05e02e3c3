#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/studies/tracking_scores.h"
#include "bench/table/table.h"

namespace ertbench {

/// A row a solver.
TableSection tracking_table(const TrackingCondition& condition, const std::string& law);

/// Which frame rate is enough: a row a solver, a column a speed; none where no speed was measured
/// at two frame rates or more.
std::vector<TableSection> frame_rate_tables(std::span<const TrackingCondition> conditions,
                                            const std::string& law);

/// All numbers and the ends of their intervals, for programs: a row for each condition and solver.
TableSection tracking_data(std::span<const TrackingCondition> conditions, const std::string& law);

}  // namespace ertbench
