#include <algorithm>
#include <cctype>
#include <sstream>
#include <string>
#include <vector>

#include "bench/report/table.h"
#include "bench/report/table_cells.h"
#include "core/text.h"

namespace ertbench {
namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

/// Keeps every character what it is: no emphasis, HTML, link, formula or new column.
std::string escaped(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '\n' || c == '\r') {
      out += ' ';
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

std::string joined(const Cell& cell) {
  std::string out;
  for (const std::string& line : cell) out += (out.empty() ? "" : "<br>") + escaped(line);
  return out;
}

/// Columns padded to equal width, so that the text reads as a table too.
void print(std::ostream& out, const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> widths(lines.front().size(), 4);
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      widths[c] = std::max(widths[c], character_count(line[c]));
    }
  }
  for (std::size_t r = 0; r < lines.size(); ++r) {
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string padding(widths[c] - character_count(lines[r][c]), ' ');
      out << (c == 0 ? "| " + lines[r][c] + padding : " | " + padding + lines[r][c]);
    }
    out << " |\n";
    if (r > 0) continue;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string rule(widths[c] - 1, '-');
      out << (c == 0 ? "| :" + rule : " | " + rule + ":");
    }
    out << " |\n";
  }
}

/// A fence longer than any run of back-ticks in what it holds.
std::string fenced(const std::string& text) {
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

std::string markdown_table(std::span<const ResultRow> rows, const TableText& text) {
  std::ostringstream out;
  if (!text.title.empty()) out << "# " << escaped(text.title) << "\n\n";
  for (const CellTable& table : cell_tables(rows, text)) {
    out << "## " << escaped(table.dataset) << "\n\n" << escaped(table.description) << "\n\n";
    std::vector<std::vector<std::string>> lines(1);
    for (const std::string& title : table.head) lines[0].push_back(escaped(title));
    for (const auto& row : table.rows) {
      std::vector<std::string>& line = lines.emplace_back();
      for (const Cell& cell : row) line.push_back(joined(cell));
    }
    print(out, lines);
    out << "\n";
    for (const std::string& note : table.notes) out << escaped(note) << "\n\n";
  }
  for (const std::string& entry : legend(rows, text)) out << "- " << escaped(entry) << "\n";
  if (!text.command.empty()) out << "\nTo make it again:\n\n" << fenced(text.command);
  return out.str();
}

}  // namespace ertbench
