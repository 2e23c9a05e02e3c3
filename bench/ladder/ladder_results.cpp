#include "bench/ladder/ladder_results.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/json.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

Between between_of(const LadderAxis& axis) {
  if (axis.integer) return Between::nothing;
  return axis.logarithmic ? Between::logarithmic : Between::linear;
}

std::string state_of(const Breakdown& breakdown) {
  constexpr const char* names[] = {"breaks", "fails at its mildest level",
                                   "never within the ladder"};
  return names[static_cast<std::size_t>(breakdown.state)];
}

std::string category_text(const LadderClimb& climb) {
  return joined(climb.levels, ", ", [](const LadderLevel& level) {
    return level.level.text() + " " +
           (level.message.empty() ? fixed(100 * level.share(), 1) + " %" : "impossible");
  });
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
    // Without one the best value is that end of the ladder.
    one.breakdown = end.value_or(Breakdown{BreakState::never, steps[range.best].level, 1, {}, {}});
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

std::optional<double> rate(int count, int total) {
  if (total == 0) return std::nullopt;
  return count / static_cast<double>(total);
}

std::vector<Cell> cells_of(const std::string& solver, const std::string& axis,
                           const std::string& name, const LadderLevel& level) {
  std::vector<Cell> cells = {solver, axis, name, std::to_string(level.frames.size()),
                             number_text(level.share())};
  for (const FailureKind kind : kFailureKinds) {
    cells.emplace_back(csv_number(rate(level.count(kind), static_cast<int>(level.frames.size()))));
  }
  const DetectionCounts counts = detection_at(level);
  for (const auto& share :
       {counts.suspect_rate(), counts.detection_rate(), counts.false_alarm_rate()}) {
    cells.emplace_back(csv_number(share));
  }
  const auto errors = quantiles(level, &JudgedFrame::error);
  for (const double FrameQuantiles::*part :
       {&FrameQuantiles::low, &FrameQuantiles::median, &FrameQuantiles::high}) {
    cells.emplace_back(errors ? number_text((*errors).*part) : "");
  }
  cells.emplace_back(level.message);
  return cells;
}

/// The axis that stands for the test set itself.
const char* const test_set = "default";

/// Appends total, count, rate and the ends of its interval.
void add_rate(int count, int total, std::vector<Cell>& cells) {
  cells.emplace_back(std::to_string(total));
  cells.emplace_back(std::to_string(count));
  cells.emplace_back(csv_number(rate(count, total)));
  std::optional<Interval> interval;
  if (total > 0) interval = wilson_interval(count, total);
  cells.emplace_back(csv_number(member_of(interval, &Interval::low)));
  cells.emplace_back(csv_number(member_of(interval, &Interval::high)));
}

/// "96.5 [93.1, 98.3]", below it "193 of 200"; a dash if `total` is 0.
Cell rate_cell(int count, int total) {
  if (total == 0) return "—";
  Cell cell = number_cell(100.0 * count / total, 1);
  const Interval interval = wilson_interval(count, total);
  cell.interval = interval_text(fixed(100 * interval.low, 1), fixed(100 * interval.high, 1));
  cell.lines = {std::to_string(count) + " of " + std::to_string(total)};
  return cell;
}

/// The section of one rate, `count` of `total`.
TableSection detection_section(const std::string& caption, const Ladders& ladders,
                               const std::vector<AxisDetection>& detections,
                               int DetectionCounts::*count, int DetectionCounts::*total) {
  TableSection section;
  section.caption = caption;
  section.columns = {{"axis", Align::left}};
  std::vector<std::pair<std::string, std::string>> axes = {{test_set, "The test set itself"}};
  for (const LadderAxis& axis : ladders.axes) axes.emplace_back(axis.name, axis.title);
  for (const AxisDetection& one : detections) {
    if (one.axis == test_set) section.columns.emplace_back(one.solver);
  }
  for (const auto& [name, title] : axes) {
    std::vector<Cell> row(section.columns.size());
    row[0] = title;
    bool climbed = false;
    for (const AxisDetection& one : detections) {
      if (one.axis != name) continue;
      const auto column =
          std::find_if(section.columns.begin() + 1, section.columns.end(),
                       [&](const Column& candidate) { return candidate.title == one.solver; });
      row[static_cast<std::size_t>(column - section.columns.begin())] =
          rate_cell(one.counts.*count, one.counts.*total);
      climbed = true;
    }
    if (climbed) section.rows.push_back(std::move(row));
  }
  return section;
}

std::vector<std::string> notes() {
  return {
      "A solver flags a frame by the status suspect, not converged or undefined. All "
      "levels of an axis are counted together, including those of the bisection; levels.csv lists "
      "each. Brackets hold Wilson's 95 % interval, which takes frames as independent. The same "
      "scenes recur at every level, so the true interval of an axis is wider.",
      "The check knows the voltages and not the truth. It misses failures on frames that are like "
      "those of the training (the validation set): the voltages are in order, but the contact is "
      "small, weak or near another, or the method or its parameter is at fault. The image of a "
      "frame that is not flagged may still be wrong.",
      "The check looks for frames unlike those that the solver was fitted for, not for images that "
      "fail. Flags begin a little beyond the training's noise or with the first fault, long "
      "before most solvers fail, so there are many false alarms on axes of noise and faults. The "
      "rate on ordinary frames is that of the test set itself.",
      "On the axes of a parameter all frames are those of the test set; most detections there are "
      "iterations that did not converge or undefined images.",
      "With the channel mask \"detect\" a frame with up to four dead electrodes is imaged without "
      "them and not flagged for them, so a failure of that image is missed."};
}

}  // namespace

std::string level_digits(double level) {
  if (level == std::round(level) && std::abs(level) < 1e5) return fixed(level, 0);
  return std::abs(level) >= 1e-3 ? three_digits(level) : with_digits(level, 3);
}

std::string AxisBreakdown::text() const {
  if (!categories.empty()) return categories;
  if (!breakdown) return state.substr(0, state.find(':'));
  const std::string level = level_digits(breakdown->level);
  if (breakdown->state == BreakState::at_mildest) return "fails at " + level + " already";
  if (breakdown->state == BreakState::never) return "holds to " + level;
  return level + breakdown_interval(*breakdown, side);
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
      // Levels at which there was no solver have no frames.
      const std::size_t frames = outcome.record->base.frames.size();
      line.frames = static_cast<int>(frames);
      line.share_at_default = outcome.record->base.share();
      if (axis.categories) {
        line.state = "categories";
        line.categories = category_text(*climb);
        out.push_back(line);
        continue;
      }
      std::vector<LadderStep> steps;
      for (const LadderLevel& level : climb->levels) steps.push_back(level.step(frames));
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

TableSection levels_data(const std::vector<LadderOutcome>& outcomes) {
  TableSection section;
  section.columns = columns_named(
      "solver axis level frames failed undefined worse_than_nothing misplaced ghost suspect "
      "detected false_alarms error_q05 error_q50 error_q95 message");
  for (const LadderOutcome& outcome : outcomes) {
    if (!outcome.record) continue;
    const std::string& solver = outcome.entry->label;
    section.rows.push_back(cells_of(solver, "default", "", outcome.record->base));
    for (const LadderClimb& climb : outcome.record->axes) {
      for (const LadderLevel& level : climb.levels) {
        const Level& at = level.level;
        section.rows.push_back(
            cells_of(solver, climb.axis, at.is_number() ? json_text(at.json()) : at.text(), level));
      }
    }
  }
  return section;
}

std::optional<double> DetectionCounts::suspect_rate() const {
  return rate(suspect, failing + good);
}
std::optional<double> DetectionCounts::detection_rate() const { return rate(detected, failing); }
std::optional<double> DetectionCounts::false_alarm_rate() const { return rate(false_alarms, good); }

DetectionCounts detection_at(const LadderLevel& level) {
  DetectionCounts counts;
  for (const JudgedFrame& frame : level.frames) {
    const bool flagged = frame.status != FrameStatus::ok;
    ++(frame.failed != 0 ? counts.failing : counts.good);
    if (flagged) ++(frame.failed != 0 ? counts.detected : counts.false_alarms);
    counts.suspect += frame.status == FrameStatus::suspect;
  }
  return counts;
}

std::vector<AxisDetection> detections_of(const std::vector<LadderOutcome>& outcomes) {
  std::vector<AxisDetection> out;
  for (const LadderOutcome& outcome : outcomes) {
    if (!outcome.record) continue;
    const std::string& solver = outcome.entry->label;
    out.push_back({solver, test_set, detection_at(outcome.record->base)});
    for (const LadderClimb& climb : outcome.record->axes) {
      LadderLevel all;
      for (const LadderLevel& level : climb.levels) {
        all.frames.insert(all.frames.end(), level.frames.begin(), level.frames.end());
      }
      out.push_back({solver, climb.axis, detection_at(all)});
    }
  }
  return out;
}

TableSection detection_data(const std::vector<AxisDetection>& detections) {
  TableSection section;
  section.columns = columns_named(
      "solver axis failing detected detection_rate detection_low detection_high good false_alarms "
      "false_alarm_rate false_alarm_low false_alarm_high");
  for (const AxisDetection& line : detections) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells = {line.solver, line.axis};
    add_rate(line.counts.detected, line.counts.failing, cells);
    add_rate(line.counts.false_alarms, line.counts.good, cells);
  }
  return section;
}

Table detection_table(const std::string& title, const Ladders& ladders,
                      const std::vector<AxisDetection>& detections) {
  Table table;
  table.title = title;
  table.sections = {
      detection_section("Detected: failing frames that the solver flagged, %", ladders, detections,
                        &DetectionCounts::detected, &DetectionCounts::failing),
      detection_section("False alarms: frames that did not fail and were flagged, %", ladders,
                        detections, &DetectionCounts::false_alarms, &DetectionCounts::good)};
  table.legend = notes();
  return table;
}

}  // namespace ertbench
