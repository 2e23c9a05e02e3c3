#pragma once

#include <string_view>

namespace ertbench {

/// Whether it may name a dataset or a chart, whose names become parts of file names: it must be
/// made of letters, digits, "_" and "-", at most 60 of them.
bool is_name(std::string_view text);

/// Whether it may label a solver: it must be made of letters, digits, spaces and any of . _ + = , -
/// (at most 60), with no dot at the start and no spaces at the ends. Labels become file names too.
bool is_label(std::string_view text);

/// Whether every character may stand in a label.
bool is_label_text(std::string_view text);

}  // namespace ertbench
