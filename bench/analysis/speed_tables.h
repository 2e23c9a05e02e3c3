#pragma once

#include <string>
#include <vector>

#include "bench/analysis/speed_accuracy.h"
#include "bench/table/text_table.h"

namespace ertbench {

/// What to take (within 1, 5 and 20 % of the least error, and for each budget), the right sizes,
/// and every configuration with its numbers.
std::vector<TextTable> speed_tables(const SpeedAccuracy& chart);

/// How the tables are to be read, in a few sentences.
std::string speed_notes(const SpeedAccuracy& chart);

/// Notes and tables as a Markdown file.
std::string speed_markdown(const SpeedAccuracy& chart, const std::string& title);

}  // namespace ertbench
