#include <algorithm>
#include <cmath>
#include <functional>

#include "bench/ladder/ladder_results.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Three significant digits, or two below a tenth, to fit into a cell.
std::string brief_digits(double level) {
  return (level < 0 ? "−" : "") + with_digits(std::abs(level), std::abs(level) < 0.1 ? 2 : 3);
}

std::string cell_text(const Breakdown& found) {
  const std::string level = brief_digits(found.level);
  if (found.state == BreakState::at_mildest) return "at " + level;
  return found.state == BreakState::never ? "ok " + level : level;
}

TableSection breakdown_section(const std::vector<AxisBreakdown>& breakdowns) {
  TableSection section;
  section.caption = "Where each solver fails";
  section.columns = {{"axis", Align::left}};
  std::vector<AxisBreakdown> lines = breakdowns;  // in the order of the file's axes
  std::ranges::stable_sort(lines, std::less<>(), &AxisBreakdown::axis);
  const auto row_of = [](const AxisBreakdown& line) {
    return line.axis->title + (line.side.empty() ? "" : ", " + line.side) +
           (line.axis->unit.empty() ? "" : " (" + line.axis->unit + ")");
  };
  const auto solvers = distinct(lines, &AxisBreakdown::solver);
  section.columns.insert(section.columns.end(), solvers.begin(), solvers.end());
  for (const std::string& row : distinct(lines, row_of)) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells.emplace_back(row);
    for (const std::string& solver : solvers) {
      const auto found = std::ranges::find_if(lines, [&](const AxisBreakdown& line) {
        return line.solver == solver && row_of(line) == row;
      });
      cells.emplace_back(found == lines.end() ? "" : found->text());
    }
  }
  return section;
}

std::vector<std::string> notes_of(const Ladders& ladders) {
  const FailureRule& rule = ladders.failure;
  return {
      "A frame fails when its image is not finite, when its relative error of δσ is " +
          number_text(rule.relative_error) +
          " or more, when its strongest contact lies more than " + number_text(rule.distance) +
          " (domain units) from a true one, or when a sheet without contact shows a change of " +
          number_text(rule.contact_threshold) + " of the background or more.",
      "A solver fails beyond the level where more than " + fixed(100 * rule.share, 1) + " %" +
          " of its frames fail: the first such crossing along the ladder, found by bisection "
          "and interpolated; in brackets the 95 % interval by resampling the frames, which are "
          "the same at all levels and for all solvers. \"before\" and \"beyond\": the interval "
          "leaves the ladder there.",
      "\"fails at … already\": at the ladder's mildest level. \"holds to …\": not even at its "
      "severest. Parameters have two rows, below and above the values that work; of levels "
      "without an order the shares of failing frames are given.",
      "By this rule an image that fades does not fail: its error comes near 1 from "
      "below. Where a solver holds, the chart of its errors says what its images are worth.",
      "no-contact, the empty image, fails on every frame with a contact by definition "
      "(its relative error is 1), and on none without."};
}

}  // namespace

std::optional<HeatMap> ladder_map_of(const std::string& title,
                                     const std::vector<AxisBreakdown>& breakdowns) {
  std::vector<AxisBreakdown> ordered = breakdowns;
  std::erase_if(ordered, [](const AxisBreakdown& line) {
    return line.axis->categories || line.axis->of_parameter();
  });
  const auto solvers = distinct(ordered, &AxisBreakdown::solver);
  auto axes = distinct(ordered, &AxisBreakdown::axis);
  if (axes.empty()) return std::nullopt;
  std::ranges::reverse(axes);  // the first on top
  HeatMap map;
  map.title = title;
  map.x_values = solvers;
  for (const LadderAxis* axis : axes) {
    map.y_values.push_back(axis->title + (axis->unit.empty() ? "" : " (" + axis->unit + ")"));
  }
  HeatMapPanel panel;
  panel.title = "level beyond which it fails";
  panel.quantity = panel.title;
  map.published_note =
      "colour: 0 fails at its mildest level (\"at\") … 1 holds to its severest (\"ok\")";
  panel.decimals = 2;
  panel.range = {0, 1};
  const std::size_t cells = solvers.size() * axes.size();
  panel.values.resize(cells);
  panel.colours.resize(cells);
  panel.texts.resize(cells);
  map.statuses.resize(cells);
  for (const AxisBreakdown& line : ordered) {
    const auto y = std::ranges::find(axes, line.axis) - axes.begin();
    const auto x = std::ranges::find(solvers, line.solver) - solvers.begin();
    const auto cell = static_cast<std::size_t>(y * std::ssize(solvers) + x);
    if (!line.breakdown) {
      map.statuses[cell] = line.state.substr(0, line.state.find(':'));
      continue;
    }
    panel.values[cell] = line.breakdown->level;
    panel.colours[cell] = line.breakdown->place;
    panel.texts[cell] = cell_text(*line.breakdown);
  }
  map.panels = {panel};
  return map;
}

TableSection breakdown_data(const std::vector<AxisBreakdown>& breakdowns) {
  TableSection section;
  section.columns = columns_named(
      "solver axis side level ci_low ci_high unit state frames share_at_default categories");
  for (const AxisBreakdown& line : breakdowns) {
    std::optional<double> level, low, high;
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
