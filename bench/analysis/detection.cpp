#include "bench/analysis/detection.h"

#include <algorithm>
#include <utility>

#include "core/csv_field.h"
#include "core/text.h"
#include "core/wilson_interval.h"

namespace ertbench {
namespace {

/// The axis that stands for the test set itself.
const char* const test_set = "default";

std::optional<double> rate(int count, int total) {
  if (total == 0) return std::nullopt;
  return count / static_cast<double>(total);
}

/// For programs: all, of these the counted, their share and the ends of its interval.
void add_rate(int count, int total, std::vector<Cell>& cells) {
  cells.emplace_back(std::to_string(total));
  cells.emplace_back(std::to_string(count));
  cells.emplace_back(csv_number(rate(count, total)));
  std::optional<Interval> interval;
  if (total > 0) interval = wilson_interval(count, total);
  cells.emplace_back(csv_number(interval ? std::optional(interval->low) : std::nullopt));
  cells.emplace_back(csv_number(interval ? std::optional(interval->high) : std::nullopt));
}

/// "96.5 [93.1, 98.3]", below it "193 of 200"; a dash where there are no such frames.
Cell rate_cell(int count, int total) {
  if (total == 0) return "—";
  Cell cell = number_cell(100.0 * count / total, 1);
  const Interval interval = wilson_interval(count, total);
  cell.interval = interval_text(fixed(100 * interval.low, 1), fixed(100 * interval.high, 1));
  cell.lines = {std::to_string(count) + " of " + std::to_string(total)};
  return cell;
}

/// One of the two sections: `count` of `total`.
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

}  // namespace

DetectionCounts& DetectionCounts::operator+=(const DetectionCounts& other) {
  failing += other.failing;
  detected += other.detected;
  good += other.good;
  false_alarms += other.false_alarms;
  suspect += other.suspect;
  return *this;
}

std::optional<double> DetectionCounts::suspect_rate() const {
  return rate(suspect, failing + good);
}
std::optional<double> DetectionCounts::detection_rate() const { return rate(detected, failing); }
std::optional<double> DetectionCounts::false_alarm_rate() const { return rate(false_alarms, good); }

DetectionCounts detection_at(const LadderLevel& level) {
  DetectionCounts counts;
  for (const JudgedFrame& frame : level.frames) {
    const bool doubted = frame.status != FrameStatus::ok;
    ++(frame.failed != 0 ? counts.failing : counts.good);
    if (doubted) ++(frame.failed != 0 ? counts.detected : counts.false_alarms);
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
      AxisDetection line{solver, climb.axis, {}};
      for (const LadderLevel& level : climb.levels) line.counts += detection_at(level);
      out.push_back(std::move(line));
    }
  }
  return out;
}

TableSection detection_data(const std::vector<AxisDetection>& detections) {
  TableSection section;
  section.columns = {"solver",          "axis",
                     "failing",         "detected",
                     "detection_rate",  "detection_low",
                     "detection_high",  "good",
                     "false_alarms",    "false_alarm_rate",
                     "false_alarm_low", "false_alarm_high"};
  for (const AxisDetection& line : detections) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells = {line.solver, line.axis};
    add_rate(line.counts.detected, line.counts.failing, cells);
    add_rate(line.counts.false_alarms, line.counts.good, cells);
  }
  return section;
}

namespace {

/// What a reader of the table must know.
std::vector<std::string> notes() {
  return {
      "A solver doubts a frame when it reports it as suspect, not converged or undefined. All "
      "levels "
      "of an axis are counted together, those of the bisection too; levels.csv has each by itself. "
      "In brackets Wilson's 95 % interval, which takes frames as independent: the same scenes come "
      "back at every level, so that the true interval of an axis is wider.",
      "What the check cannot see: it knows the voltages and not the truth. A failure on a frame "
      "that "
      "is like those of the training (the validation set) passes unseen, as when voltages that are "
      "in order give a wrong image because the contact is small, weak or near another, or because "
      "the method or its parameter is at fault. A frame that is not doubted is an ordinary frame; "
      "its image may be wrong all the same.",
      "The check looks for frames unlike those that the solver was fitted for, not for images that "
      "fail: doubt begins a little beyond the training's noise, or with the first fault, long "
      "before "
      "most solvers fail. So the false alarms on axes of noise and faults are many; the rate on "
      "ordinary frames is the one of the test set itself.",
      "On the axes of a parameter all frames are those of the test set; what is detected there is "
      "mostly an iteration that did not converge or an image that is undefined.",
      "With the channel mask \"detect\" a frame with up to four dead electrodes is imaged without "
      "them and is not doubted for them: where that image fails all the same, it passes unseen."};
}

}  // namespace

Table detection_table(const std::string& title, const Ladders& ladders,
                      const std::vector<AxisDetection>& detections) {
  Table table;
  table.title = title;
  table.sections = {
      detection_section("Detected: failing frames that the solver doubted, %", ladders, detections,
                        &DetectionCounts::detected, &DetectionCounts::failing),
      detection_section("False alarms: frames that did not fail and were doubted, %", ladders,
                        detections, &DetectionCounts::false_alarms, &DetectionCounts::good)};
  table.legend = notes();
  return table;
}

}  // namespace ertbench
