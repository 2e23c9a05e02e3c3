#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/analysis/ladder_results.h"
#include "bench/table/table.h"

namespace ertbench {

/// Frames of one solver, by whether they failed and whether the solver doubted them: whether its
/// status was suspect, not converged or undefined.
struct DetectionCounts {
  int failing = 0;       ///< frames that failed by the rule
  int detected = 0;      ///< of these the doubted ones
  int good = 0;          ///< frames that did not fail
  int false_alarms = 0;  ///< of these the doubted ones
  int suspect = 0;       ///< of all frames, those whose status was suspect

  DetectionCounts& operator+=(const DetectionCounts& other);
  /// Shares; none where there are no such frames.
  std::optional<double> suspect_rate() const;      ///< of all frames
  std::optional<double> detection_rate() const;    ///< detected, of the failing frames
  std::optional<double> false_alarm_rate() const;  ///< false alarms, of the good frames
};

DetectionCounts detection_at(const LadderLevel& level);

/// All levels together that one solver climbed on one axis: a line of detection.csv.
struct AxisDetection {
  std::string solver;
  std::string axis;  ///< "default" for the test set itself
  DetectionCounts counts;
};

/// Solver by solver, the test set first; nothing of solvers without a record.
std::vector<AxisDetection> detections_of(const std::vector<LadderOutcome>& outcomes);

/// For programs: solver, axis, failing, detected, detection_rate, detection_low, detection_high,
/// good, false_alarms, false_alarm_rate, false_alarm_low, false_alarm_high: ends of Wilson's 95 %
/// intervals; rates of no frames are empty.
TableSection detection_data(const std::vector<AxisDetection>& detections);

/// For people: detection rates, then false alarms; a row for the test set and each axis, a column
/// for each solver, in per cent with interval and counts.
Table detection_table(const std::string& title, const Ladders& ladders,
                      const std::vector<AxisDetection>& detections);

}  // namespace ertbench
