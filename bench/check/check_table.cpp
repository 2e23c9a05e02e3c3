#include "bench/check/check_table.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "core/text.h"

namespace ertbench {
namespace {

using Fields = std::array<std::string, 6>;

const Fields head = {"row", "quantity", "old", "new", "allowed", "verdict"};

Fields fields_of(const CheckLine& line) {
  return {line.row, line.quantity, line.before, line.now, line.allowed, name_of(line.verdict)};
}

/// The lines of one row, which stand together.
std::vector<std::span<const CheckLine>> by_row(std::span<const CheckLine> lines) {
  std::vector<std::span<const CheckLine>> out;
  while (!lines.empty()) {
    const auto end = std::find_if(lines.begin(), lines.end(), [&](const CheckLine& line) {
      return line.row != lines.front().row;
    });
    const auto count = static_cast<std::size_t>(end - lines.begin());
    out.push_back(lines.first(count));
    lines = lines.subspan(count);
  }
  return out;
}

Verdict worst(std::span<const CheckLine> lines) {
  Verdict verdict = Verdict::ok;
  for (const CheckLine& line : lines) verdict = std::max(verdict, line.verdict);
  return verdict;
}

Fields summary_of(std::span<const CheckLine> row) {
  const auto ok = std::count_if(row.begin(), row.end(),
                                [](const CheckLine& line) { return line.verdict == Verdict::ok; });
  const std::string all = std::to_string(row.size());
  const std::string quantities = row.size() == 1 ? " quantity" : " quantities";
  const bool every = static_cast<std::size_t>(ok) == row.size();
  return {row.front().row,
          (every ? all : std::to_string(ok) + " of " + all) + quantities,
          "",
          "",
          "",
          name_of(worst(row))};
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (std::string("|\\*_`<>&").find(c) != std::string::npos) out += '\\';
    out += c;
  }
  return out;
}

}  // namespace

std::string check_table(std::span<const CheckLine> lines, bool all) {
  std::vector<Fields> shown = {head};
  for (const auto& row : by_row(lines)) {
    for (const CheckLine& line : row) {
      if (all || line.verdict != Verdict::ok) shown.push_back(fields_of(line));
    }
    if (row.size() > 1) shown.push_back(summary_of(row));
  }
  std::array<std::size_t, head.size()> widths{};
  for (const Fields& fields : shown) {
    for (std::size_t c = 0; c < fields.size(); ++c) {
      widths[c] = std::max(widths[c], character_count(fields[c]));
    }
  }
  std::string out;
  for (const Fields& fields : shown) {
    std::string text;
    for (std::size_t c = 0; c < fields.size(); ++c) {
      text += fields[c] + std::string(widths[c] - character_count(fields[c]) + 2, ' ');
    }
    out += text.substr(0, text.find_last_not_of(' ') + 1) + "\n";
  }
  return out;
}

std::string check_markdown(std::span<const CheckLine> lines) {
  std::string out;
  const auto print = [&](const Fields& fields) {
    for (const std::string& field : fields) out += "| " + escaped(field) + " ";
    out += "|\n";
  };
  print(head);
  out += "|---|---|---:|---:|---:|---|\n";
  for (const CheckLine& line : lines) print(fields_of(line));
  return out;
}

std::string check_summary(std::span<const CheckLine> lines) {
  std::map<Verdict, int> counts;
  for (const auto& row : by_row(lines)) ++counts[worst(row)];
  std::string out;
  for (const auto& [verdict, count] : counts) {
    if (out.empty()) {
      out = std::to_string(count) + (count == 1 ? " row " : " rows ") + name_of(verdict);
    } else {
      out += ", " + std::to_string(count) + " " + name_of(verdict);
    }
  }
  return out.empty() ? "no rows" : out;
}

}  // namespace ertbench
