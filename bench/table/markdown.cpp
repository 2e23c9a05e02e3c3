#include "core/markdown.h"

#include <algorithm>

#include "bench/table/writers.h"
#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

std::string text_of(const Cell& cell) {
  std::string out = markdown_escaped(cell.text);
  if (!cell.interval.empty()) out += (out.empty() ? "" : " ") + markdown_escaped(cell.interval);
  for (const std::string& line : cell.lines)
    out += (out.empty() ? "" : "<br>") + markdown_escaped(line);
  return out;
}

/// The titles of the columns, then the rows.
std::vector<std::vector<std::string>> texts_of(const TableSection& section) {
  std::vector<std::vector<std::string>> lines(1);
  for (const Column& column : section.columns) lines[0].push_back(markdown_escaped(column.title));
  for (const auto& row : section.rows) {
    std::vector<std::string>& line = lines.emplace_back();
    for (const Cell& cell : row) line.push_back(text_of(cell));
  }
  return lines;
}

/// Columns padded to equal width, so that the text reads as a table too.
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

/// A fence longer than any run of back-ticks in what it holds.
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
  if (!table.command.empty()) out << "\nTo make it again:\n\n" << fenced(table.command);
  return out.str();
}

}  // namespace ertbench
