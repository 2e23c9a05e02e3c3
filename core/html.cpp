#include "core/html.h"

#include "core/text.h"

namespace ertbench {
std::string html_escaped(std::string_view text) {
  std::string out;
  for (const char32_t point : code_points(text)) {
    switch (point) {
      case U'&':
        out += "&amp;";
        break;
      case U'<':
        out += "&lt;";
        break;
      case U'>':
        out += "&gt;";
        break;
      case U'"':
        out += "&quot;";
        break;
      case U'\'':
        out += "&#39;";
        break;
      default:
        if (point == U'\n' || point == U'\t') {
          out += static_cast<char>(point);
        } else if (!is_control(point)) {
          append_utf8(out, point);
        }
    }
  }
  return out;
}

}  // namespace ertbench
