#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/ladder/ladder_record.h"
#include "bench/record/result_row.h"
#include "bench/report/heat_map.h"
#include "bench/report/report.h"
#include "bench/table/table.h"

namespace ertbench {

/// The level at which one solver fails on one axis: a line of breakdown.csv. A parameter with an
/// order has two lines, below and above the values that work.
struct AxisBreakdown {
  std::string solver;
  const LadderAxis* axis = nullptr;
  std::string side;   ///< "below", "above", or empty
  std::string state;  ///< "breaks", "fails at its mildest level", "never within the ladder",
                      ///< "fails at every level", "categories", or what went wrong
  std::optional<Breakdown> breakdown;  ///< for the first three states
  std::string categories;              ///< "disc 0.0 %, ring 12.5 %": shares of failing frames
  int frames = 0;                      ///< at each level
  std::optional<double> share_at_default;

  /// A cell of a table: "27.3 (31.2 … 25.0)".
  std::string text() const;
};

/// Solver by solver, axis by axis.
std::vector<AxisBreakdown> breakdowns_of(const Ladders& ladders,
                                         const std::vector<LadderOutcome>& outcomes);

/// breakdown.csv: solver, axis, side, level, ci_low, ci_high, unit, state, frames,
/// share_at_default, categories; ends of an interval outside the ladder are empty.
TableSection breakdown_data(const std::vector<AxisBreakdown>& breakdowns);
/// levels.csv: solver, axis, level, frames, failed, undefined, worse_than_nothing, misplaced,
/// ghost, suspect, detected, false_alarms, error_q05, error_q50, error_q95, message. The six from
/// "failed" are shares of the frames, the next two rates of DetectionCounts; axis "default" is the
/// test set.
TableSection levels_data(const std::vector<LadderOutcome>& outcomes);

/// breakdown.md: a row for each axis (and side), a column for each solver.
Table breakdown_table(const std::string& title, const Ladders& ladders,
                      const std::vector<AxisBreakdown>& breakdowns);

/// "27.3", "8", "0.0450", "2.6e-08": three significant digits; whole numbers without decimals.
std::string level_digits(double level);

/// 5, 50 and 95 % quantiles over the frames that have a value.
struct FrameQuantiles {
  double low = 0;
  double median = 0;
  double high = 0;
};
std::optional<FrameQuantiles> quantiles(const LadderLevel& level,
                                        std::optional<double> JudgedFrame::*value);

/// Frames of one solver, by whether they failed and whether the solver flagged them: its status was
/// suspect, not converged or undefined.
struct DetectionCounts {
  int failing = 0;       ///< frames that failed by the rule
  int detected = 0;      ///< flagged frames among the failing ones
  int good = 0;          ///< frames that did not fail
  int false_alarms = 0;  ///< flagged frames among the good ones
  int suspect = 0;       ///< flagged frames (status suspect) among all

  std::optional<double> suspect_rate() const;      ///< share of all frames
  std::optional<double> detection_rate() const;    ///< share of the failing frames; nothing: none
  std::optional<double> false_alarm_rate() const;  ///< share of the good frames; nothing: none
};

DetectionCounts detection_at(const LadderLevel& level);

/// Counts over all levels of one solver on one axis: a line of detection.csv.
struct AxisDetection {
  std::string solver;
  std::string axis;  ///< "default" for the test set itself
  DetectionCounts counts;
};

/// Solver by solver, the test set first; solvers without a record are left out.
std::vector<AxisDetection> detections_of(const std::vector<LadderOutcome>& outcomes);

/// detection.csv: solver, axis, failing, detected, detection_rate, detection_low, detection_high,
/// good, false_alarms, false_alarm_rate, false_alarm_low, false_alarm_high, with Wilson's 95 %
/// intervals; rates of no frames are empty.
TableSection detection_data(const std::vector<AxisDetection>& detections);

/// detection.md: detection rates, then false alarms, in per cent with interval and counts; a row
/// for the test set and each axis, a column for each solver.
Table detection_table(const std::string& title, const Ladders& ladders,
                      const std::vector<AxisDetection>& detections);

/// Map of the levels at which solvers (columns) fail on the ordered axes of the scenes (rows): the
/// colour is 0 at the mildest level and 1 at the severest, the text is the level. Nothing if no
/// axis has an order.
std::optional<HeatMap> ladder_map_of(const std::string& title,
                                     const std::vector<AxisBreakdown>& breakdowns);

/// Draws one axis for all solvers that climbed it, as `stem`.svg and `stem`.png: above, the share
/// of failing frames over the level, with the limit beyond which a solver fails; below, the median
/// relative error with whiskers from 5 to 95 %. The mildest level is on the left. More than seven
/// solvers are divided among several columns with the same axes. Throws InputError if gnuplot is
/// missing or a file cannot be written.
void draw_ladder_chart(const Ladders& ladders, const LadderAxis& axis,
                       const std::vector<LadderOutcome>& outcomes,
                       const std::filesystem::path& stem);

/// Writes breakdown.csv, breakdown.md, levels.csv, detection.csv, detection.md, a chart of each
/// axis, `ladder_`axis.svg and .png, and the map breakdown.svg and .png into `folder`. Returns
/// their sections of the report; none if the experiment has no ladders.
std::vector<ReportSection> write_ladder_results(const Experiment& experiment,
                                                const std::vector<LadderOutcome>& outcomes,
                                                const Builds& builds,
                                                const std::filesystem::path& folder);

}  // namespace ertbench
