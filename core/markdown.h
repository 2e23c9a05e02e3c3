#pragma once

#include <string>
#include <string_view>

namespace ertbench {

/// `text` as one line of Markdown in which every character is what it is: no emphasis, HTML, link,
/// formula or new column of a table, and printable.
std::string markdown_escaped(std::string_view text);

}  // namespace ertbench
