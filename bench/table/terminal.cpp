#include <algorithm>

#include "bench/table/writers.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Line = std::vector<std::string>;

/// All of it in one line, without anything that the terminal would obey.
std::string shown(const std::string& text) { return printable(text, text.size()); }

/// The lines of a row: its texts, and below them what more there is to say.
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
  if (std::any_of(titles.begin(), titles.end(), [](const auto& t) { return !t.empty(); })) {
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
  if (!table.command.empty()) add("To make it again: " + shown(table.command) + "\n");
  return out;
}

}  // namespace ertbench
