#pragma once

#include <span>
#include <string>

#include "bench/check/check.h"
#include "bench/check/noticeable.h"
#include "bench/table/table.h"

namespace ertbench {

/// Columns row, quantity, old, new, notices, verdict, for the terminal: what is not "ok" (or every
/// line, with `all`), and after each row's lines one for the whole row with its worst verdict.
Table check_table(std::span<const CheckLine> lines, bool all);

/// All lines.
Table check_report(std::span<const CheckLine> lines);

/// A row for each row of the baseline and a column for each metric: from where on a worsening is
/// noticed.
Table noticeable_table(std::span<const Noticeable> all);

/// How many rows came out how: "7 rows ok, 1 better, 1 worse".
std::string check_summary(std::span<const CheckLine> lines);

}  // namespace ertbench
