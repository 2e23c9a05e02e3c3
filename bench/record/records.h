#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "bench/score/metrics.h"
#include "core/arrays.h"
#include "solvers/solver.h"

namespace ertbench {

/// The parts of a trial, each a process of its own: fitting, reconstructing and scoring, and the
/// ladders, may share the machine with other trials; the clock wants it alone.
enum class Stage { accuracy, timing, ladders };

const char* name_of(Stage stage);

/// One process: a whole accuracy stage, or one round of a timing stage. Rounds of all solvers are
/// run in turn, so that what disturbs the machine for a while falls on all of them.
struct StagePart {
  Stage stage = Stage::accuracy;
  int round = 0;  ///< of a timing stage, from 0
};

/// What determines a record of accuracy or timing; a record with the same key need not be made
/// again. That of the ladders is in ladder_record.h.
std::string record_key(const Experiment& experiment, const SolverEntry& entry, Stage stage);

/// `folder`/records/`stem`.accuracy.json, `stem`.timing.2.json, `stem`.ladders.json; the trial's
/// log and its progress stand beside it under other endings.
std::filesystem::path record_file(const std::filesystem::path& folder, const SolverEntry& entry,
                                  StagePart part, const std::string& ending = ".json");

/// What one trial did on one test set.
struct ScoredSet {
  ResultRow row;
  std::vector<FrameMetrics> frames;
  std::vector<FrameStatus> statuses;  ///< [frames]
};

/// `{"schema", "key", "fit_s", "fit_report": {"status", "message"}, "rows", "frames": {dataset:
/// {metric: [values], "status", "reasons", "iterations", "gap"}}, "figure_images": [[S/m]]}`; where
/// sizes are chosen on it, the validation set is the last of the datasets.
struct AccuracyRecord {
  std::vector<ScoredSet> sets;  ///< of each test set; the rows' statuses are the fit report's
  std::optional<ScoredSet> validation;
  Images figure_images;  ///< [figure scenes, pixels] S/m
};

/// What the clock said on one test set.
struct MeasuredTimes {
  LatencySummary latency_us;
  double frames_per_s = 0;  ///< median of the rounds
  int batch = 0;            ///< frames in a call where the throughput was measured
};

/// Of each round `{"schema", "key", "timing": {dataset: {"latency_us": [every frame],
/// "frames_per_s", "batch"}}, "calibration_us", "peak_rss_mb"}`, put together.
struct TimingRecord {
  std::map<std::string, MeasuredTimes> sets;  ///< by test set
  double calibration_us = 0;                  ///< median of the rounds
  double peak_rss_mb = 0;                     ///< largest of the rounds
};

/// The records of finished stages in the result folder; nothing where there is none with the right
/// key, or none that can be read, or a round of the timing is missing.
std::optional<AccuracyRecord> read_accuracy_record(const Experiment& experiment,
                                                   const SolverEntry& entry,
                                                   const std::filesystem::path& folder);
std::optional<TimingRecord> read_timing_record(const Experiment& experiment,
                                               const SolverEntry& entry,
                                               const std::filesystem::path& folder);
bool has_record(const Experiment& experiment, const SolverEntry& entry, StagePart part,
                const std::filesystem::path& folder);

/// Version of what records hold; part of their keys.
inline constexpr int record_schema = 4;

}  // namespace ertbench
