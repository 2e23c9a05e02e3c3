#include "bench/analysis/ladder_results.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/csv_field.h"
#include "core/quantile.h"
#include "core/text.h"

namespace ertbench {
namespace {

std::string percent(double share) { return fixed(100 * share, 1) + " %"; }

Between between_of(const LadderAxis& axis) {
  if (axis.integer) return Between::nothing;
  return axis.logarithmic ? Between::logarithmic : Between::linear;
}

std::string state_of(const Breakdown& breakdown) {
  switch (breakdown.state) {
    case BreakState::breaks:
      return "breaks";
    case BreakState::at_mildest:
      return "fails at its mildest level";
    case BreakState::never:
      return "never within the ladder";
  }
  return "";
}

/// Frames at each level; the levels at which there was no solver have none.
std::size_t frames_of(const LadderRecord& record) { return record.base.frames.size(); }

std::vector<LadderStep> steps_of(const LadderClimb& climb, std::size_t frames) {
  std::vector<LadderStep> steps;
  for (const LadderLevel& level : climb.levels) steps.push_back(level.step(frames));
  return steps;
}

std::string category_text(const LadderClimb& climb) {
  std::string out;
  for (const LadderLevel& level : climb.levels) {
    out += (out.empty() ? "" : ", ") + level.level.text() + " ";
    out += level.message.empty() ? percent(level.share()) : "impossible";
  }
  return out;
}

/// The lines of a parameter: from its best value towards both ends.
std::vector<AxisBreakdown> range_lines(const AxisBreakdown& line, const LadderAxis& axis,
                                       const std::vector<LadderStep>& steps, double limit) {
  const WorkingRange range = working_range(steps, limit, between_of(axis), axis.name);
  if (steps[range.best].share() > limit) {
    AxisBreakdown one = line;
    one.state = "fails at every level";
    return {one};
  }
  const bool rises = steps.back().level > steps.front().level;
  std::vector<AxisBreakdown> lines;
  for (const bool below : {true, false}) {
    AxisBreakdown one = line;
    one.side = below ? "below" : "above";
    const std::optional<Breakdown>& end = below == rises ? range.to_first : range.to_last;
    if (end) {
      one.breakdown = end;
    } else {  // the best value is that end of the ladder
      one.breakdown = Breakdown{BreakState::never, steps[range.best].level, 1, {}, {}};
    }
    one.state = state_of(*one.breakdown);
    lines.push_back(one);
  }
  return lines;
}

std::string interval_text(const Breakdown& breakdown, const std::string& side) {
  if (breakdown.mild && breakdown.mild == breakdown.severe) return "";
  const std::string mild = breakdown.mild ? level_digits(*breakdown.mild) : "before";
  const std::string severe = breakdown.severe ? level_digits(*breakdown.severe) : "beyond";
  return side == "below" ? " (" + severe + " … " + mild + ")" : " (" + mild + " … " + severe + ")";
}

}  // namespace

std::string level_digits(double level) {
  if (level == std::round(level) && std::abs(level) < 1e5) return fixed(level, 0);
  if (std::abs(level) >= 1e-3) return three_digits(level);
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", level);
  return text;
}

std::string AxisBreakdown::text() const {
  if (!categories.empty()) return categories;
  if (!breakdown) return state.substr(0, state.find(':'));
  switch (breakdown->state) {
    case BreakState::breaks:
      return level_digits(breakdown->level) + interval_text(*breakdown, side);
    case BreakState::at_mildest:
      return "fails at " + level_digits(breakdown->level) + " already";
    case BreakState::never:
      return "holds to " + level_digits(breakdown->level);
  }
  return "";
}

std::vector<AxisBreakdown> breakdowns_of(const Ladders& ladders,
                                         const std::vector<LadderOutcome>& outcomes) {
  std::vector<AxisBreakdown> out;
  for (const LadderOutcome& outcome : outcomes) {
    for (const LadderAxis& axis : ladders.axes) {
      if (!axis.concerns(*outcome.entry)) continue;
      AxisBreakdown line;
      line.solver = outcome.entry->label;
      line.axis = &axis;
      const LadderClimb* climb = outcome.record ? outcome.record->find(axis.name) : nullptr;
      if (!climb) {
        line.state = outcome.failure;
        out.push_back(line);
        continue;
      }
      const std::size_t frames = frames_of(*outcome.record);
      line.frames = static_cast<int>(frames);
      line.share_at_default = outcome.record->base.share();
      if (axis.categories) {
        line.state = "categories";
        line.categories = category_text(*climb);
        out.push_back(line);
        continue;
      }
      const std::vector<LadderStep> steps = steps_of(*climb, frames);
      const double limit = ladders.failure.share;
      if (axis.of_parameter()) {
        const auto lines = range_lines(line, axis, steps, limit);
        out.insert(out.end(), lines.begin(), lines.end());
      } else {
        line.breakdown = break_down(steps, limit, between_of(axis), axis.name);
        line.state = state_of(*line.breakdown);
        out.push_back(line);
      }
    }
  }
  return out;
}

std::string breakdown_csv(const std::vector<AxisBreakdown>& breakdowns) {
  std::ostringstream out;
  out << "solver,axis,side,level,ci_low,ci_high,unit,state,frames,share_at_default,categories\n";
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
    out << csv_field(line.solver) << ',' << line.axis->name << ',' << line.side << ','
        << csv_number(level) << ',' << csv_number(low) << ',' << csv_number(high) << ','
        << csv_field(line.axis->unit) << ',' << csv_field(line.state) << ',' << line.frames << ','
        << csv_number(line.share_at_default) << ',' << csv_field(line.categories) << '\n';
  }
  return out.str();
}

TextTable breakdown_table(const std::vector<AxisBreakdown>& breakdowns) {
  TextTable table{"Where each solver breaks down", {"axis"}, {}};
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
  table.header.insert(table.header.end(), solvers.begin(), solvers.end());
  for (const std::string& row : rows) {
    std::vector<std::string>& line = table.rows.emplace_back();
    line.push_back(row);
    for (const std::string& solver : solvers) {
      const auto found = cells.find({row, solver});
      line.push_back(found == cells.end() ? "" : found->second);
    }
  }
  return table;
}

std::vector<std::string> breakdown_notes(const Ladders& ladders) {
  const FailureRule& rule = ladders.failure;
  return {"A frame fails when its image is not finite, when its relative error of δσ is " +
              number_text(rule.relative_error) +
              " or more, when its strongest contact lies more than " + number_text(rule.distance) +
              " (domain units) from a true one, or when a blank sheet shows a change of " +
              number_text(rule.contact_threshold) + " of the background or more.",
          "A solver breaks down at the level where more than " + percent(rule.share) +
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

std::string breakdown_markdown(const std::string& title, const Ladders& ladders,
                               const std::vector<AxisBreakdown>& breakdowns) {
  std::string out = "# " + title + "\n\n" + markdown_of(breakdown_table(breakdowns)) + "\n";
  for (const std::string& note : breakdown_notes(ladders)) out += "- " + note + "\n";
  return out;
}

std::optional<FrameQuantiles> quantiles(const LadderLevel& level,
                                        std::optional<double> JudgedFrame::*value) {
  std::vector<double> values;
  for (const JudgedFrame& frame : level.frames) {
    if (frame.*value) values.push_back(*(frame.*value));
  }
  if (values.empty()) return std::nullopt;
  const SortedValues sorted = values;
  return FrameQuantiles{interpolated_quantile(sorted, 0.05), median(sorted),
                        interpolated_quantile(sorted, 0.95)};
}

}  // namespace ertbench
