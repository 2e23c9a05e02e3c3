#include "core/csv_field.h"

#include <charconv>
#include <cmath>

#include "core/text.h"

namespace ertbench {
namespace {

bool is_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  return end.ec == std::errc() && end.ptr == text.data() + text.size() && std::isfinite(value);
}

/// Whether a spreadsheet would compute it, or it looks like what we write in place of such a field.
bool needs_apostrophe(std::string_view text) {
  const std::size_t first = text.find_first_not_of("' ");
  return first != std::string_view::npos &&
         std::string_view("=+-@\t\r\n").find(text[first]) != std::string_view::npos;
}

}  // namespace

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
