#include "core/markdown.h"

#include <cctype>

#include "core/text.h"

namespace ertbench {
namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string markdown_escaped(std::string_view raw) {
  const std::string text = printable(raw, raw.size());
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else {
      const bool has_next = i + 1 < text.size();
      const bool link = c == ']' && has_next && (text[i + 1] == '(' || text[i + 1] == '[');
      const bool emphasis =
          c == '_' && !(i > 0 && has_next && is_word(text[i - 1]) && is_word(text[i + 1]));
      if (link || emphasis || std::string("|\\*`~$").find(c) != std::string::npos) out += '\\';
      out += c;
    }
  }
  return out;
}

}  // namespace ertbench
