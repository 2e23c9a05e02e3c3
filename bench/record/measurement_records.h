#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/experiment/solver_entry.h"
#include "bench/record/result_row.h"
#include "bench/score/image_contacts.h"
#include "bench/score/metrics.h"
#include "core/arrays.h"
#include "solvers/solver.h"

namespace ertbench {

/// `{"contacts": [[x_mm, y_mm, strength, peak, area_mm2], ...], "peak", "sum", "centroid_mm": [x,
/// y], "centroid25_mm": [x, y], "explained"}` in the units of FrameReading; null where there is no
/// value.
nlohmann::json to_json(const FrameReading& reading);

/// Scores of one trial on one test set.
struct ScoredSet {
  ResultRow row;
  std::vector<FrameMetrics> frames;
  std::vector<FrameStatus> statuses;  ///< [frames]
  /// [frames], where the experiment keeps them; else empty.
  std::vector<FrameReading> readings;
};

/// `{"schema", "key", "fit_s", "fit_report": {"status", "message"}, "rows", "frames": {dataset:
/// {metric: [values], "status", "reasons", "iterations", "gap"}}, "figure_images": [[S/m]]}`; where
/// sizes are chosen on it, the validation set is the last of the datasets. Where the experiment
/// keeps contacts, a dataset has its "readings" (FrameReading) too.
struct AccuracyRecord {
  std::vector<ScoredSet> sets;  ///< of each test set; the rows' statuses are the fit report's
  std::optional<ScoredSet> validation;
  Images figure_images;  ///< [figure scenes, pixels] S/m
};

/// Key of the record: a hash of the solver, the test sets and what the experiment has kept of them.
std::string accuracy_key(const Experiment& experiment, const SolverEntry& entry);

/// Throws an exception of any kind where the JSON is not such a record. `source` names the file.
AccuracyRecord accuracy_record_from_json(const nlohmann::json& record, const Experiment& experiment,
                                         const std::string& source);

/// Times measured on one test set.
struct MeasuredTimes {
  LatencySummary latency_us;
  double frames_per_s = 0;  ///< median of the rounds
  int batch = 0;            ///< frames in a call where the throughput was measured
};

/// The record of each round is `{"schema", "key", "timing": {dataset: {"latency_us": [every frame],
/// "frames_per_s", "batch", "contacts_us": [frames, to the contacts], "pipe_us": [every frame
/// through Solver::transport, if any]}}, "calibration_us", "peak_rss_mb", "place"}`, put together.
struct TimingRecord {
  std::map<std::string, MeasuredTimes> sets;  ///< by test set
  double calibration_us = 0;                  ///< median of the rounds
  double peak_rss_mb = 0;                     ///< largest of the rounds
  TimingPlace place;                          ///< the first round's, with the busiest load
};

/// The latency of one round in units of what calibration_us() took just before it, in the same
/// process: whatever clock rate the processor had then, both had. Of frames under a millisecond the
/// median counts; a longer one is seldom left alone on a busy machine, and the fastest counts.
double relative_latency(double median_us, double fastest_us, double calibration_us);

/// Key of the record of any round: the solver, the test sets, how the clock
/// is used. The processor is no part of it; it stands in the record.
std::string timing_key(const Experiment& experiment, const SolverEntry& entry);

/// Where a round was measured. Throws an exception of any kind where it does not say.
TimingPlace timing_place_of(const nlohmann::json& round);
nlohmann::json to_json(const TimingPlace& place);

/// Puts all rounds together, one at least. Throws an exception of any kind where one is not such a
/// record.
TimingRecord timing_record_from_json(const std::vector<nlohmann::json>& rounds);

}  // namespace ertbench
