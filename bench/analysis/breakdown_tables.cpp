#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/analysis/ladder_results.h"
#include "core/csv_field.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// A row for each axis (and side), a column for each solver.
TableSection breakdown_section(const std::vector<AxisBreakdown>& breakdowns) {
  TableSection section;
  section.caption = "Where each solver breaks down";
  section.columns = {{"axis", Align::left}};
  std::vector<std::string> solvers;
  std::vector<std::string> rows;
  std::map<std::pair<std::string, std::string>, std::string> cells;
  const auto place_of = [](std::vector<std::string>& list, const std::string& name) {
    if (std::find(list.begin(), list.end(), name) == list.end()) list.push_back(name);
  };
  std::vector<AxisBreakdown> lines = breakdowns;  // in the order of the file's axes
  std::stable_sort(lines.begin(), lines.end(), [](const AxisBreakdown& a, const AxisBreakdown& b) {
    return std::less<>()(a.axis, b.axis);
  });
  for (const AxisBreakdown& line : lines) {
    std::string row = line.axis->title;
    if (!line.side.empty()) row += ", " + line.side;
    if (!line.axis->unit.empty()) row += " (" + line.axis->unit + ")";
    place_of(solvers, line.solver);
    place_of(rows, row);
    cells[{row, line.solver}] = line.text();
  }
  for (const std::string& solver : solvers) section.columns.emplace_back(solver);
  for (const std::string& row : rows) {
    std::vector<Cell>& line = section.rows.emplace_back();
    line.emplace_back(row);
    for (const std::string& solver : solvers) {
      const auto found = cells.find({row, solver});
      line.emplace_back(found == cells.end() ? "" : found->second);
    }
  }
  return section;
}

/// What a reader of the table must know.
std::vector<std::string> notes_of(const Ladders& ladders) {
  const FailureRule& rule = ladders.failure;
  return {"A frame fails when its image is not finite, when its relative error of δσ is " +
              number_text(rule.relative_error) +
              " or more, when its strongest contact lies more than " + number_text(rule.distance) +
              " (domain units) from a true one, or when a blank sheet shows a change of " +
              number_text(rule.contact_threshold) + " of the background or more.",
          "A solver breaks down at the level where more than " + fixed(100 * rule.share, 1) + " %" +
              " of its frames fail: the first such crossing along the ladder, found by bisection "
              "and interpolated; in brackets the 95 % interval by resampling the frames, which are "
              "the same at all levels and for all solvers. \"before\" and \"beyond\": the interval "
              "leaves the ladder there.",
          "\"fails at … already\": at the ladder's mildest level. \"holds to …\": not even at its "
          "severest. Parameters have two rows, below and above the values that work; of levels "
          "without an order the shares of failing frames are given.",
          "By this rule an image that fades to nothing does not fail: its error comes near 1 from "
          "below. Where a solver holds, the chart of its errors says what its images are worth.",
          "no-contact, the image of nothing, fails on every frame with a contact by definition "
          "(its relative error is 1), and on no blank one."};
}

}  // namespace

TableSection breakdown_data(const std::vector<AxisBreakdown>& breakdowns) {
  TableSection section;
  section.columns = {"solver",    "axis", "side",  "level",  "ci_low",
                     "ci_high",   "unit", "state", "frames", "share_at_default",
                     "categories"};
  for (const AxisBreakdown& line : breakdowns) {
    std::optional<double> level;
    std::optional<double> low;
    std::optional<double> high;
    if (line.breakdown) {
      const Breakdown& found = *line.breakdown;
      level = found.level;
      low = found.mild;
      high = found.severe;
      // From milder to severer levels fall where the ladder does.
      const double first = line.axis->levels.front().number();
      const double last = line.axis->levels.back().number();
      const bool falls = line.side.empty() ? last < first : line.side == "below";
      if (falls) std::swap(low, high);
    }
    section.rows.push_back({line.solver, line.axis->name, line.side, csv_number(level),
                            csv_number(low), csv_number(high), line.axis->unit, line.state,
                            std::to_string(line.frames), csv_number(line.share_at_default),
                            line.categories});
  }
  return section;
}

Table breakdown_table(const std::string& title, const Ladders& ladders,
                      const std::vector<AxisBreakdown>& breakdowns) {
  Table table;
  table.title = title;
  table.sections = {breakdown_section(breakdowns)};
  table.legend = notes_of(ladders);
  return table;
}

}  // namespace ertbench
