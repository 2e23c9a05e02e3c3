#pragma once

#include <string>

#include "bench/table/text_table.h"

namespace ertbench {

/// The table as HTML. "\n" in a cell begins a new line (class "more"); the first cell of a row is
/// its name. Columns of numbers (class "number") are found by their cells: they stand to the right,
/// intervals in brackets on lines of their own, and break where they can be read. Throws
/// std::invalid_argument where a row is not as long as the header.
std::string html_table(const TextTable& table);

}  // namespace ertbench
