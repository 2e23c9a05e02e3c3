#include "bench/report/html_table.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "core/html.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// "0.34", "−1", "—", "± 0.1", "1 / 2".
bool begins_as_number(const std::string& cell) {
  if (cell.empty() || (cell[0] >= '0' && cell[0] <= '9')) return true;
  const auto begins = [&](const char* sign) { return cell.starts_with(sign); };
  return begins("−") || begins("—") || begins("±") || begins("+") || begins("[");
}

/// Numbers stand to the right, a column of words to the left.
bool is_number_column(const TextTable& table, std::size_t column) {
  const auto numbers = std::count_if(
      table.rows.begin(), table.rows.end(),
      [&](const std::vector<std::string>& row) { return begins_as_number(row[column]); });
  return column > 0 && 2 * static_cast<std::size_t>(numbers) > table.rows.size();
}

/// A line of numbers that breaks before "(" and "over" and after "to" and "%," only.
std::string kept_together(const std::string& line) {
  std::string out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::string_view before = std::string_view(line).substr(0, i);
    const std::string_view after = std::string_view(line).substr(i);
    const bool breaks = after.starts_with(" (") || after.starts_with(" over") ||
                        before.ends_with(" to") || before.ends_with("%,");
    out += line[i] == ' ' && !breaks ? "\u00a0" : std::string(1, line[i]);
  }
  return out;
}

/// The lines of a cell. In a column of numbers an interval has a line of its own, and so has what
/// follows a dash.
std::vector<std::string> lines_of(const std::string& cell, bool is_number) {
  std::vector<std::string> lines = split(cell, "\n");
  if (!is_number) return lines;
  const std::string dash = "— ";
  std::vector<std::string> out;
  for (const std::string& line : lines) {
    const std::size_t end = line.starts_with(dash) ? dash.size() - 1 : line.find(" [");
    out.push_back(kept_together(line.substr(0, end)));
    if (end != std::string::npos) out.push_back(kept_together(line.substr(end + 1)));
  }
  return out;
}

/// The words of a name break only where they are longer than a line: not "alpha=1e-" and "07".
std::string unbroken_words(const std::string& name) {
  std::string out;
  for (const std::string& word : split(name, " ")) {
    out += (out.empty() ? "" : " ") + ("<span class=\"word\">" + html_escaped(word)) + "</span>";
  }
  return out;
}

std::string more_lines(const std::vector<std::string>& lines) {
  std::string out;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    out += "<span class=\"more\">" + html_escaped(lines[i]) + "</span>";
  }
  return out;
}

}  // namespace

std::string html_table(const TextTable& table) {
  for (const auto& row : table.rows) {
    if (row.empty() || row.size() != table.header.size()) {
      throw std::invalid_argument("table: " + table.caption + ": a cell for each column");
    }
  }
  std::vector<bool> numbers;
  for (std::size_t c = 0; c < table.header.size(); ++c) {
    numbers.push_back(is_number_column(table, c));
  }
  const auto class_of = [&](std::size_t c) { return numbers[c] ? " class=\"number\"" : ""; };
  std::ostringstream out;
  out << "<table>\n<caption>" << html_escaped(table.caption) << "</caption>\n<thead><tr>";
  for (std::size_t c = 0; c < numbers.size(); ++c) {
    out << "<th scope=\"col\"" << class_of(c) << ">" << html_escaped(table.header[c]) << "</th>";
  }
  out << "</tr></thead>\n<tbody>\n";
  for (const auto& row : table.rows) {
    const std::vector<std::string> name = lines_of(row.front(), false);
    out << "<tr><th scope=\"row\">" << unbroken_words(name.front()) << more_lines(name) << "</th>";
    for (std::size_t c = 1; c < row.size(); ++c) {
      const std::vector<std::string> lines = lines_of(row[c], numbers[c]);
      out << "<td" << class_of(c) << ">" << html_escaped(lines.front()) << more_lines(lines)
          << "</td>";
    }
    out << "</tr>\n";
  }
  out << "</tbody>\n</table>\n";
  return out.str();
}

}  // namespace ertbench
