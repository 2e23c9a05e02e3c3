#include "core/text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace ertbench {
namespace {

constexpr char32_t replacement = 0xfffd;

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xc0U) != 0x80U; }

/// Number of bytes after the first one of a character; -1 if `first` cannot be a first byte.
int following_bytes(unsigned char first) {
  if (first < 0x80) return 0;
  if (first < 0xc2) return -1;
  if (first < 0xe0) return 1;
  if (first < 0xf0) return 2;
  return first < 0xf5 ? 3 : -1;
}

/// Smallest code point that needs so many following bytes; smaller ones are overlong forms.
char32_t least_of(int following) {
  return following == 1 ? 0x80 : following == 2 ? 0x800 : 0x10000;
}

bool is_character(char32_t point) {
  return point <= 0x10ffff && (point < 0xd800 || point > 0xdfff);
}

std::string without_controls(std::string_view text, std::size_t most, bool keep_lines) {
  std::string out;
  std::size_t characters = 0;
  // A character has four bytes at most; text that is cut off need not be decoded.
  const std::size_t enough = most < text.size() / 4 ? 4 * (most + 1) : text.size();
  for (const char32_t point : code_points(text.substr(0, enough))) {
    if (characters++ == most) return out + "…";
    const bool line_end = point == U'\n' || point == U'\r' || point == U'\t';
    if (point == U'\n' && keep_lines) {
      out += '\n';
    } else if (line_end) {
      out += ' ';
    } else {
      append_utf8(out, is_control(point) ? replacement : point);
    }
  }
  return out;
}

/// Splits after each hyphen, underscore or run of white space; lines are broken between pieces.
std::vector<std::string_view> pieces_of(std::string_view text) {
  std::vector<std::string_view> pieces;
  std::size_t start = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool last = i + 1 == text.size();
    const bool space_ends = is_space(text[i]) && !last && !is_space(text[i + 1]);
    if (last || space_ends || text[i] == '-' || text[i] == '_') {
      pieces.push_back(text.substr(start, i + 1 - start));
      start = i + 1;
    }
  }
  return pieces;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

/// True if the unknown word is probably a misspelling of the known one.
bool is_slip(std::string_view word, std::string_view known) {
  const auto end = std::mismatch(word.begin(), word.end(), known.begin(), known.end()).first;
  const auto common = static_cast<std::size_t>(end - word.begin());
  return edit_distance(word, known) <= std::max<std::size_t>(2, word.size() / 3) ||
         (common >= 4 && 2 * common >= word.size());
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

bool is_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() && end.ptr == text.data() + text.size() && std::isfinite(value);
}

/// True if a spreadsheet would evaluate the text, or if it looks like a field with our apostrophe.
bool needs_apostrophe(std::string_view text) {
  const std::size_t first = text.find_first_not_of("' ");
  return first != std::string_view::npos &&
         std::string_view("=+-@\t\r\n").find(text[first]) != std::string_view::npos;
}

}  // namespace

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "—";
  const bool large = std::abs(value) >= 1e7;
  std::array<char, 64> buffer{};
  const auto end = std::to_chars(buffer.begin(), buffer.end(), std::abs(value),
                                 large ? std::chars_format::scientific : std::chars_format::fixed,
                                 large ? 2 : decimals);
  const std::string digits(buffer.begin(), end.ptr);
  const bool zero = digits.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !zero ? "−" + digits : digits;
}

std::string with_digits(double value, int digits) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string number_text(double value) { return with_digits(value, 6); }

std::string three_digits(double value) {
  if (value == 0 || !std::isfinite(value)) return fixed(value, 0);
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(value))));
  return fixed(value, std::clamp(2 - exponent, 0, 5));
}

std::vector<char32_t> code_points(std::string_view text) {
  std::vector<char32_t> out;
  for (std::size_t i = 0; i < text.size();) {
    const auto first = static_cast<unsigned char>(text[i++]);
    const int following = following_bytes(first);
    if (following <= 0) {
      out.push_back(following == 0 ? char32_t{first} : replacement);
      continue;
    }
    char32_t point = first & (0x3fU >> static_cast<unsigned>(following));
    int read = 0;
    for (; read < following && i < text.size() && !begins_character(text[i]); ++read, ++i) {
      point = (point << 6U) | (static_cast<unsigned char>(text[i]) & 0x3fU);
    }
    out.push_back(read == following && point >= least_of(following) && is_character(point)
                      ? point
                      : replacement);
  }
  return out;
}

void append_utf8(std::string& text, char32_t point) {
  if (!is_character(point)) point = replacement;
  const auto byte = [&](char32_t bits) { text += static_cast<char>(bits); };
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

bool is_control(char32_t point) {
  return point < 0x20 || (point >= 0x7f && point < 0xa0) || (point >= 0x202a && point <= 0x202e) ||
         (point >= 0x2066 && point <= 0x2069) || (point & 0xfffeU) == 0xfffeU;
}

std::string printable(std::string_view text, std::size_t most) {
  return without_controls(text, most, false);
}

std::string printable_lines(std::string_view text, std::size_t most) {
  return without_controls(text, most, true);
}

std::size_t character_count(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

std::string one_line(std::string_view text, std::size_t length) {
  std::string out;
  std::size_t characters = 0;
  for (const char c : text) {
    if (is_space(c) && (out.empty() || out.back() == ' ')) continue;
    if (begins_character(c) && characters++ == length) return out + "…";
    out += is_space(c) ? ' ' : c;
  }
  if (!out.empty() && out.back() == ' ') out.pop_back();
  return out;
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  const std::string line = one_line(text, text.size());
  std::vector<std::string> lines(1);
  for (const std::string_view piece : pieces_of(line)) {
    const std::string_view word = piece.substr(0, piece.size() - (piece.back() == ' ' ? 1 : 0));
    const std::size_t used = character_count(lines.back());
    if (used > 0 && used + character_count(word) > width) lines.emplace_back();
    for (const char c : piece) {
      // A space at the end of a line may exceed the width; it is cut off below.
      const bool full = character_count(lines.back()) >= width;
      if (full && begins_character(c) && c != ' ') lines.emplace_back();
      lines.back() += c;
    }
  }
  for (std::string& l : lines) {
    if (!l.empty() && l.back() == ' ') l.pop_back();
  }
  return lines;
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::vector<std::string> split(std::string_view text, std::string_view separator) {
  std::vector<std::string> parts;
  while (true) {
    const std::size_t end = text.find(separator);
    parts.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + separator.size());
  }
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& known) {
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
        return edit_distance(word, a) < edit_distance(word, b);
      });
  return nearest != known.end() && is_slip(word, *nearest) ? *nearest : "";
}

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

std::string html_escaped(std::string_view text) {
  std::string out;
  for (const char32_t point : code_points(text)) {
    const char* const entity = point == U'&'    ? "&amp;"
                               : point == U'<'  ? "&lt;"
                               : point == U'>'  ? "&gt;"
                               : point == U'"'  ? "&quot;"
                               : point == U'\'' ? "&#39;"
                                                : nullptr;
    if (entity) {
      out += entity;
    } else if (point == U'\n' || point == U'\t' || !is_control(point)) {
      append_utf8(out, point);
    }
  }
  return out;
}

std::string csv_field(std::string_view field) {
  const bool text_only = needs_apostrophe(field) && !is_number(field);
  std::string text = (text_only ? "'" : "") + std::string(field);
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + "\"";
}

std::string csv_number(const std::optional<double>& value) {
  return value ? number_text(*value) : "";
}

std::vector<std::vector<std::string>> csv_lines(std::string_view text) {
  std::vector<std::vector<std::string>> lines;
  std::vector<std::string> line;
  std::string field;
  bool quoted = false;
  const auto end_field = [&] {
    if (field.starts_with('\'') && needs_apostrophe(field)) field.erase(0, 1);
    line.push_back(std::move(field));
    field.clear();
  };
  const auto end_line = [&] {
    end_field();
    lines.push_back(std::move(line));
    line.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' && quoted && i + 1 < text.size() && text[i + 1] == '"') {
      field += text[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      end_field();
    } else if (c == '\n' && !quoted) {
      end_line();
    } else if (c != '\r' || quoted) {
      field += c;
    }
  }
  if (!field.empty() || !line.empty()) end_line();
  return lines;
}

}  // namespace ertbench
