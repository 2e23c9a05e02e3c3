#pragma once

#include <string>
#include <string_view>

namespace ertbench {

/// `text` as it may stand in the content or a quoted attribute of HTML and SVG: markup escaped,
/// bytes that are not UTF-8 as U+FFFD, control characters (is_control) other than tab and new line
/// left out.
std::string html_escaped(std::string_view text);

}  // namespace ertbench
