#include "bench/analysis/ladder_results.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

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

std::string breakdown_interval(const Breakdown& breakdown, const std::string& side) {
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
      return level_digits(breakdown->level) + breakdown_interval(*breakdown, side);
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
