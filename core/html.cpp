#include "core/html.h"

#include "core/text.h"

namespace ertbench {
namespace {

bool is_character(char32_t point) {
  return point < 0xd800 || (point > 0xdfff && point < 0xfffe) ||
         (point > 0xffff && point <= 0x10ffff);
}

void append_utf8(std::string& out, char32_t point) {
  if (!is_character(point)) point = 0xfffd;
  const auto byte = [&](char32_t bits) { out += static_cast<char>(bits); };
  const auto following = [&](unsigned shift) { byte(0x80U | (point >> shift & 0x3fU)); };
  if (point < 0x80) {
    byte(point);
  } else if (point < 0x800) {
    byte(0xc0U | point >> 6U);
    following(0);
  } else if (point < 0x10000) {
    byte(0xe0U | point >> 12U);
    following(6);
    following(0);
  } else {
    byte(0xf0U | point >> 18U);
    following(12);
    following(6);
    following(0);
  }
}

}  // namespace

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
        if (point >= 0x20 && point != 0x7f) {
          append_utf8(out, point);
        } else if (point == U'\n' || point == U'\t') {
          out += static_cast<char>(point);
        }
    }
  }
  return out;
}

}  // namespace ertbench
