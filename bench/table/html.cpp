#include "core/html.h"

#include <string_view>

#include "bench/table/writers.h"
#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

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

/// The lines of a cell. An interval has a line of its own below a number.
std::vector<std::string> lines_of(const Cell& cell, Align align) {
  std::vector<std::string> lines = {cell.text};
  if (!cell.interval.empty()) lines.push_back(cell.interval);
  lines.insert(lines.end(), cell.lines.begin(), cell.lines.end());
  if (align == Align::right) {
    for (std::string& line : lines) line = kept_together(line);
  }
  return lines;
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

std::string html_of(const TableSection& section) {
  section.require_cells();
  const auto class_of = [&](std::size_t c) {
    return c > 0 && section.columns[c].align == Align::right ? " class=\"number\"" : "";
  };
  TextStream out;
  out << "<table>\n<caption>" << html_escaped(section.caption) << "</caption>\n<thead><tr>";
  for (std::size_t c = 0; c < section.columns.size(); ++c) {
    out << "<th scope=\"col\"" << class_of(c) << ">" << html_escaped(section.columns[c].title)
        << "</th>";
  }
  out << "</tr></thead>\n<tbody>\n";
  for (const auto& row : section.rows) {
    const std::vector<std::string> name = lines_of(row.front(), Align::left);
    out << "<tr><th scope=\"row\">" << unbroken_words(name.front()) << more_lines(name) << "</th>";
    for (std::size_t c = 1; c < row.size(); ++c) {
      const std::vector<std::string> lines = lines_of(row[c], section.columns[c].align);
      out << "<td" << class_of(c) << ">" << html_escaped(lines.front()) << more_lines(lines)
          << "</td>";
    }
    out << "</tr>\n";
  }
  out << "</tbody>\n</table>\n";
  return out.str();
}

}  // namespace ertbench
