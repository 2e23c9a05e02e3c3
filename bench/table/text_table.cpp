#include "bench/table/text_table.h"

namespace ertbench {
namespace {

std::string line(const std::vector<std::string>& cells) {
  std::string out = "|";
  for (const std::string& cell : cells) {
    out += ' ';
    for (const char c : cell) {
      if (c == '|') out += '\\';
      out += c == '\n' ? ' ' : c;
    }
    out += " |";
  }
  return out + "\n";
}

}  // namespace

std::string markdown_of(const TextTable& table) {
  std::string out = "## " + table.caption + "\n\n" + line(table.header) + "|";
  for (std::size_t i = 0; i < table.header.size(); ++i) out += i == 0 ? "---|" : "---:|";
  out += "\n";
  for (const auto& row : table.rows) out += line(row);
  return out;
}

}  // namespace ertbench
