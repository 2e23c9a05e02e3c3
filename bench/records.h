#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment.h"
#include "bench/metrics.h"
#include "bench/result_row.h"
#include "forward/arrays.h"
#include "solvers/solver.h"

namespace ertbench {

/// The two halves of a trial, each a process of its own: fitting, reconstructing and scoring may
/// share the machine with other trials; the clock wants it alone.
enum class Stage { accuracy, timing };

const char* name_of(Stage stage);

/// What determines a record; a record with the same key need not be made again.
std::string record_key(const Experiment& experiment, const SolverEntry& entry, Stage stage);

/// `folder`/records/`stem`.accuracy.json and so on; the trial's log and its progress stand beside
/// it under other endings.
std::filesystem::path record_file(const std::filesystem::path& folder, const SolverEntry& entry,
                                  Stage stage, const std::string& ending = ".json");

/// What one trial did on one test set.
struct ScoredSet {
  ResultRow row;
  std::vector<FrameMetrics> frames;
  std::vector<FrameStatus> statuses;  ///< [frames]
};

/// `{"schema", "key", "fit_s", "fit_report": {"status", "message"}, "rows", "frames": {dataset:
/// {metric: [values], "status", "iterations", "gap"}}, "figure_images": [[S/m]]}`.
struct AccuracyRecord {
  std::vector<ScoredSet> sets;  ///< of each test set; the rows' statuses are the fit report's
  Images figure_images;         ///< [figure scenes, pixels] S/m
};

/// What the clock said on one test set.
struct MeasuredTimes {
  LatencySummary latency_us;
  double frames_per_s = 0;
  int batch = 0;  ///< frames in a call where the throughput was measured
};

/// `{"schema", "key", "timing": {dataset: {"latency_us": [every frame], "frames_per_s", "batch"}},
/// "peak_rss_mb"}`.
struct TimingRecord {
  std::map<std::string, MeasuredTimes> sets;  ///< by test set
  double peak_rss_mb = 0;
};

/// The records of finished stages in the result folder; nothing where there is none with the right
/// key, or none that can be read.
std::optional<AccuracyRecord> read_accuracy_record(const Experiment& experiment,
                                                   const SolverEntry& entry,
                                                   const std::filesystem::path& folder);
std::optional<TimingRecord> read_timing_record(const Experiment& experiment,
                                               const SolverEntry& entry,
                                               const std::filesystem::path& folder);
bool has_record(const Experiment& experiment, const SolverEntry& entry, Stage stage,
                const std::filesystem::path& folder);

/// Version of what records hold; part of their keys.
inline constexpr int record_schema = 2;

}  // namespace ertbench
