#include <nlohmann/json.hpp>

#include "bench/analysis/detection.h"
#include "bench/analysis/ladder_results.h"
#include "core/csv_field.h"
#include "core/json_text.h"
#include "core/text.h"

namespace ertbench {

namespace {

std::vector<Cell> cells_of(const std::string& solver, const std::string& axis,
                           const std::string& name, const LadderLevel& level) {
  std::vector<Cell> cells = {solver, axis, name, std::to_string(level.frames.size()),
                             number_text(level.share())};
  for (const FailureKind kind : kFailureKinds) {
    if (level.frames.empty()) {
      cells.emplace_back();
    } else {
      cells.emplace_back(number_text(level.count(kind) / static_cast<double>(level.frames.size())));
    }
  }
  const DetectionCounts counts = detection_at(level);
  cells.emplace_back(csv_number(counts.suspect_rate()));
  cells.emplace_back(csv_number(counts.detection_rate()));
  cells.emplace_back(csv_number(counts.false_alarm_rate()));
  const auto errors = quantiles(level, &JudgedFrame::error);
  for (const double FrameQuantiles::*part :
       {&FrameQuantiles::low, &FrameQuantiles::median, &FrameQuantiles::high}) {
    cells.emplace_back(errors ? number_text((*errors).*part) : "");
  }
  cells.emplace_back(level.message);
  return cells;
}

}  // namespace

TableSection levels_data(const std::vector<LadderOutcome>& outcomes) {
  TableSection section;
  section.columns = {"solver",
                     "axis",
                     "level",
                     "frames",
                     "failed",
                     "undefined",
                     "worse_than_nothing",
                     "misplaced",
                     "ghost",
                     "suspect",
                     "detected",
                     "false_alarms",
                     "error_q05",
                     "error_q50",
                     "error_q95",
                     "message"};
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

}  // namespace ertbench
