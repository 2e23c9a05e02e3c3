#include "bench/table/table.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "core/text.h"

namespace ertbench {

Cell number_cell(const std::optional<double>& value, int decimals) {
  Cell cell(value ? fixed(*value, decimals) : "—");
  cell.value = value;
  return cell;
}

Cell exact_cell(const std::optional<double>& value) {
  Cell cell;
  if (!value || !std::isfinite(*value)) return cell;
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.begin(), buffer.end(), *value);
  cell.text.assign(buffer.begin(), end.ptr);
  cell.value = value;
  return cell;
}

std::string interval_text(const std::string& low, const std::string& high) {
  return "[" + low + ", " + high + "]";
}

std::vector<Column> columns_named(std::string_view names) {
  const std::vector<std::string> all = split(names, " ");
  return {all.begin(), all.end()};
}

void TableSection::require_cells() const {
  for (const std::vector<Cell>& row : rows) {
    if (row.empty() || row.size() != columns.size()) {
      throw std::invalid_argument("table: " + caption + ": a cell for each column");
    }
  }
}

std::string csv_of(const TableSection& section) {
  section.require_cells();
  std::string out;
  for (std::size_t c = 0; c < section.columns.size(); ++c) {
    out += (c > 0 ? "," : "") + csv_field(printable_lines(section.columns[c].title));
  }
  out += "\n";
  for (const auto& row : section.rows) {
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string text =
          row[c].value ? exact_cell(row[c].value).text : printable_lines(row[c].text);
      out += (c > 0 ? "," : "") + csv_field(text);
    }
    out += "\n";
  }
  return out;
}

namespace {

std::string text_of(const Cell& cell) {
  std::string out = markdown_escaped(cell.text);
  if (!cell.interval.empty()) out += (out.empty() ? "" : " ") + markdown_escaped(cell.interval);
  for (const std::string& line : cell.lines)
    out += (out.empty() ? "" : "<br>") + markdown_escaped(line);
  return out;
}

/// Escaped texts [line][column]: titles, then rows.
std::vector<std::vector<std::string>> texts_of(const TableSection& section) {
  std::vector<std::vector<std::string>> lines(1);
  for (const Column& column : section.columns) lines[0].push_back(markdown_escaped(column.title));
  for (const auto& row : section.rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (const Cell& cell : row) line.push_back(text_of(cell));
  }
  return lines;
}

void print(std::ostream& out, const TableSection& section) {
  const std::vector<std::vector<std::string>> lines = texts_of(section);
  std::vector<std::size_t> widths(section.columns.size(), 4);
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      widths[c] = std::max(widths[c], character_count(line[c]));
    }
  }
  for (std::size_t r = 0; r < lines.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string padding(widths[c] - character_count(lines[r][c]), ' ');
      const bool right = section.columns[c].align == Align::right;
      out << (c == 0 ? "| " : " | ") << (right ? padding + lines[r][c] : lines[r][c] + padding);
    }
    out << " |\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string rule(widths[c] - 1, '-');
      const bool right = section.columns[c].align == Align::right;
      out << (c == 0 ? "| " : " | ") << (right ? rule + ":" : ":" + rule);
    }
    out << " |\n";
  }
}

/// Paragraphs, an empty line between two.
std::string paragraphs(const std::string& text) {
  std::string out;
  for (const std::string& paragraph : split(text, "\n\n")) {
    if (!paragraph.empty()) out += markdown_escaped(paragraph) + "\n\n";
  }
  return out;
}

/// A code block whose fence is longer than any run of back-ticks in the command.
std::string fenced(const std::string& command) {
  const std::string text = printable_path(command);
  std::size_t longest = 2;
  std::size_t run = 0;
  for (const char c : text) {
    run = c == '`' ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  const std::string fence(longest + 1, '`');
  return fence + "sh\n" + text + "\n" + fence + "\n";
}

using Line = std::vector<std::string>;

/// The whole text in one line, without control characters.
std::string shown(const std::string& text) { return printable(text, text.size()); }

/// The lines of a row: its texts, then the further lines of its cells.
std::vector<Line> lines_of(const std::vector<Cell>& row) {
  std::vector<Line> lines(1);
  for (std::size_t c = 0; c < row.size(); ++c) {
    const Cell& cell = row[c];
    const std::string gap = cell.text.empty() || cell.interval.empty() ? "" : " ";
    lines[0].push_back(shown(cell.text + gap + cell.interval));
    lines.resize(std::max(lines.size(), 1 + cell.lines.size()));
  }
  for (std::size_t l = 1; l < lines.size(); ++l) {
    for (const Cell& cell : row) {
      lines[l].push_back(l <= cell.lines.size() ? shown(cell.lines[l - 1]) : "");
    }
  }
  return lines;
}

std::string padded(const Line& line, const TableSection& section,
                   const std::vector<std::size_t>& widths) {
  std::string out;
  for (std::size_t c = 0; c < line.size(); ++c) {
    const std::string space(widths[c] - character_count(line[c]), ' ');
    if (c > 0) out += "  ";
    out += section.columns[c].align == Align::right ? space + line[c] : line[c] + space;
  }
  return out.substr(0, out.find_last_not_of(' ') + 1) + "\n";
}

std::string text_of(const TableSection& section) {
  section.require_cells();
  std::vector<Line> lines;
  Line titles;
  for (const Column& column : section.columns) titles.push_back(shown(column.title));
  if (std::ranges::any_of(titles, [](const auto& t) { return !t.empty(); })) {
    lines.push_back(titles);
  }
  for (const auto& row : section.rows) {
    for (Line& line : lines_of(row)) lines.push_back(std::move(line));
  }
  std::vector<std::size_t> widths(section.columns.size());
  for (const Line& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      widths[c] = std::max(widths[c], character_count(line[c]));
    }
  }
  std::string out = section.caption.empty() ? "" : shown(section.caption) + "\n";
  if (!section.text.empty()) out += printable_lines(section.text) + "\n";
  for (const Line& line : lines) out += padded(line, section, widths);
  for (const std::string& note : section.notes) out += "    " + printable_lines(note) + "\n";
  return out;
}

}  // namespace

std::string markdown_of(const Table& table) {
  TextStream out;
  if (!table.title.empty()) out << "# " << markdown_escaped(table.title) << "\n\n";
  out << paragraphs(table.text);
  for (const TableSection& section : table.sections) {
    section.require_cells();
    if (!section.caption.empty()) out << "## " << markdown_escaped(section.caption) << "\n\n";
    out << paragraphs(section.text);
    print(out, section);
    out << "\n";
    for (const std::string& note : section.notes) out << markdown_escaped(note) << "\n\n";
  }
  for (const std::string& entry : table.legend) out << "- " << markdown_escaped(entry) << "\n";
  if (!table.command.empty()) out << "\nTo reproduce it:\n\n" << fenced(table.command);
  return out.str();
}

std::string terminal_of(const Table& table) {
  std::string out;
  const auto add = [&](const std::string& block) {
    if (!block.empty()) out += (out.empty() ? "" : "\n") + block;
  };
  add(table.title.empty() ? "" : shown(table.title) + "\n");
  add(table.text.empty() ? "" : printable_lines(table.text) + "\n");
  for (const TableSection& section : table.sections) add(text_of(section));
  std::string legend;
  for (const std::string& entry : table.legend) legend += "- " + shown(entry) + "\n";
  add(legend);
  if (!table.command.empty()) add("To reproduce it: " + shown(table.command) + "\n");
  return out;
}

}  // namespace ertbench
