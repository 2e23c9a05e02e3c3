#include "bench/analysis/detection.h"

#include <algorithm>
#include <sstream>
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

std::string csv_rate(int count, int total) {
  std::string out = std::to_string(total) + "," + std::to_string(count) + ",";
  if (total == 0) return out + ",,";
  const Interval interval = wilson_interval(count, total);
  return out + csv_number(rate(count, total)) + "," + csv_number(interval.low) + "," +
         csv_number(interval.high);
}

/// "96.5 (93.1 … 98.3)", below it "193 of 200"; a dash where there are no such frames.
std::string cell(int count, int total) {
  if (total == 0) return "—";
  const Interval interval = wilson_interval(count, total);
  return fixed(100.0 * count / total, 1) + " (" + fixed(100 * interval.low, 1) + " … " +
         fixed(100 * interval.high, 1) + ")\n" + std::to_string(count) + " of " +
         std::to_string(total);
}

/// One of the two tables: `count` of `total`.
TextTable table_of(const std::string& caption, const Ladders& ladders,
                   const std::vector<AxisDetection>& detections, int DetectionCounts::*count,
                   int DetectionCounts::*total) {
  TextTable table{caption, {"axis"}, {}};
  std::vector<std::pair<std::string, std::string>> axes = {{test_set, "The test set itself"}};
  for (const LadderAxis& axis : ladders.axes) axes.emplace_back(axis.name, axis.title);
  for (const AxisDetection& one : detections) {
    if (one.axis == test_set) table.header.push_back(one.solver);
  }
  for (const auto& [name, title] : axes) {
    std::vector<std::string> row(table.header.size());
    row[0] = title;
    bool climbed = false;
    for (const AxisDetection& one : detections) {
      if (one.axis != name) continue;
      const auto column = std::find(table.header.begin() + 1, table.header.end(), one.solver);
      row[static_cast<std::size_t>(column - table.header.begin())] =
          cell(one.counts.*count, one.counts.*total);
      climbed = true;
    }
    if (climbed) table.rows.push_back(std::move(row));
  }
  return table;
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

std::string detection_csv(const std::vector<AxisDetection>& detections) {
  std::ostringstream out;
  out << "solver,axis,failing,detected,detection_rate,detection_low,detection_high,good,"
         "false_alarms,false_alarm_rate,false_alarm_low,false_alarm_high\n";
  for (const AxisDetection& line : detections) {
    const DetectionCounts& counts = line.counts;
    out << csv_field(line.solver) << ',' << line.axis << ','
        << csv_rate(counts.detected, counts.failing) << ','
        << csv_rate(counts.false_alarms, counts.good) << '\n';
  }
  return out.str();
}

std::vector<TextTable> detection_tables(const Ladders& ladders,
                                        const std::vector<AxisDetection>& detections) {
  return {table_of("Detected: failing frames that the solver doubted, %", ladders, detections,
                   &DetectionCounts::detected, &DetectionCounts::failing),
          table_of("False alarms: frames that did not fail and were doubted, %", ladders,
                   detections, &DetectionCounts::false_alarms, &DetectionCounts::good)};
}

std::vector<std::string> detection_notes() {
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

std::string detection_markdown(const std::string& title, const Ladders& ladders,
                               const std::vector<AxisDetection>& detections) {
  std::string out = "# " + title + "\n\n";
  for (const TextTable& table : detection_tables(ladders, detections)) {
    out += markdown_of(table) + "\n";
  }
  for (const std::string& note : detection_notes()) out += "- " + note + "\n";
  return out;
}

}  // namespace ertbench
