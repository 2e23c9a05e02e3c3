#include "bench/check/check_table.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace ertbench {
namespace {

std::vector<Column> columns() {
  return {{"row", Align::left},    {"quantity", Align::left}, "old", "new", "notices",
          {"verdict", Align::left}};
}

std::vector<Cell> cells_of(const CheckLine& line) {
  return {line.row, line.quantity, line.before, line.now, line.notices, name_of(line.verdict)};
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

std::vector<Cell> summary_of(std::span<const CheckLine> row) {
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

}  // namespace

Table check_table(std::span<const CheckLine> lines, bool all) {
  Table table;
  TableSection& section = table.sections.emplace_back();
  section.columns = columns();
  for (const auto& row : by_row(lines)) {
    for (const CheckLine& line : row) {
      if (all || line.verdict != Verdict::ok) section.rows.push_back(cells_of(line));
    }
    if (row.size() > 1) section.rows.push_back(summary_of(row));
  }
  return table;
}

Table check_report(std::span<const CheckLine> lines) {
  Table table;
  TableSection& section = table.sections.emplace_back();
  section.columns = columns();
  for (const CheckLine& line : lines) section.rows.push_back(cells_of(line));
  return table;
}

Table noticeable_table(std::span<const Noticeable> all) {
  std::set<std::string> datasets;
  std::vector<Metric> metrics;
  for (const Noticeable& one : all) {
    datasets.insert(one.dataset);
    if (std::find(metrics.begin(), metrics.end(), one.metric) == metrics.end())
      metrics.push_back(one.metric);
  }
  Table table;
  TableSection& section = table.sections.emplace_back();
  section.caption = "The smallest worsening that this check notices";
  section.columns = {{"row", Align::left}};
  for (const Metric metric : metrics) section.columns.emplace_back(name_of(metric));
  std::string before;
  for (const Noticeable& one : all) {
    const std::string row = datasets.size() > 1 ? one.row + " (" + one.dataset + ")" : one.row;
    if (section.rows.empty() || row != before) {
      section.rows.emplace_back(section.columns.size(), Cell("-")).front() = row;
      before = row;
    }
    const auto place = std::find(metrics.begin(), metrics.end(), one.metric) - metrics.begin();
    section.rows.back()[static_cast<std::size_t>(place) + 1] = text_of(one);
  }
  return table;
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
