#include "core/csv_field.h"

#include "core/text.h"

namespace ertbench {

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
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
  const auto end_line = [&] {
    line.push_back(std::move(field));
    lines.push_back(std::move(line));
    field.clear();
    line.clear();
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"' && quoted && i + 1 < text.size() && text[i + 1] == '"') {
      field += text[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      line.push_back(std::move(field));
      field.clear();
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
