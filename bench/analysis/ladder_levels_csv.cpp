#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/analysis/detection.h"
#include "bench/analysis/ladder_results.h"
#include "core/csv_field.h"
#include "core/text.h"

namespace ertbench {

std::string levels_csv(const std::vector<LadderOutcome>& outcomes) {
  std::ostringstream out;
  out << "solver,axis,level,frames,failed,undefined,worse_than_nothing,misplaced,ghost,suspect,"
         "detected,false_alarms,error_q05,error_q50,error_q95,message\n";
  const auto write = [&](const std::string& solver, const std::string& axis,
                         const std::string& name, const LadderLevel& level) {
    out << csv_field(solver) << ',' << axis << ',' << csv_field(name) << ',' << level.frames.size()
        << ',' << number_text(level.share());
    for (const FailureKind kind : kFailureKinds) {
      out << ',';
      if (level.frames.empty()) continue;
      out << number_text(level.count(kind) / static_cast<double>(level.frames.size()));
    }
    const DetectionCounts counts = detection_at(level);
    out << ',' << csv_number(counts.suspect_rate()) << ',' << csv_number(counts.detection_rate())
        << ',' << csv_number(counts.false_alarm_rate());
    const auto errors = quantiles(level, &JudgedFrame::error);
    for (const double FrameQuantiles::*part :
         {&FrameQuantiles::low, &FrameQuantiles::median, &FrameQuantiles::high}) {
      out << ',' << (errors ? number_text((*errors).*part) : "");
    }
    out << ',' << csv_field(level.message) << '\n';
  };
  for (const LadderOutcome& outcome : outcomes) {
    if (!outcome.record) continue;
    write(outcome.entry->label, "default", "", outcome.record->base);
    for (const LadderClimb& climb : outcome.record->axes) {
      for (const LadderLevel& level : climb.levels) {
        const Level& at = level.level;
        write(outcome.entry->label, climb.axis, at.is_number() ? at.json().dump() : at.text(),
              level);
      }
    }
  }
  return out.str();
}

}  // namespace ertbench
