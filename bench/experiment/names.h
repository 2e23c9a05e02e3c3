#pragma once

#include <string_view>

namespace ertbench {

/// Of datasets and charts, which become parts of file names: letters, digits, "_" and "-", at most
/// 60 of them.
bool is_name(std::string_view text);

/// Of solvers: letters, digits, spaces and any of . _ + = , - (at most 60), without a dot at the
/// start and spaces at the ends. Labels become file names too.
bool is_label(std::string_view text);

/// Whether every character may stand in a label.
bool is_label_text(std::string_view text);

}  // namespace ertbench
