#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// A field as RFC 4180 has it: quoted where it holds a comma, a quote or a line end. A spreadsheet
/// would compute what begins with "=", "+", "-" or "@", behind blanks, tabs and line ends too; an
/// apostrophe before it makes it a text (OWASP, CSV injection). Numbers stay what they are.
std::string csv_field(std::string_view text);
/// The fields of each line of CSV text, quotes and the apostrophes of csv_field taken off; a last
/// line without an end counts.
std::vector<std::vector<std::string>> csv_lines(std::string_view text);
/// With six digits; empty where there is none.
std::string csv_number(const std::optional<double>& value);

}  // namespace ertbench
