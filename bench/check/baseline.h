#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/check/tolerance.h"
#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"

namespace ertbench {

class SolverRegistry;

/// Times that are roughly independent of the machine: multiples of calibration_us() in the same
/// process.
struct RelativeTimes {
  double latency = 0;      ///< one frame, the median of the rounds' relative_latency()
  double batch_frame = 0;  ///< one frame of a batch

  bool operator==(const RelativeTimes&) const = default;
};

/// Nothing if the row was not timed.
std::optional<RelativeTimes> relative_times(const ResultRow& row);

/// A stored row, which a check must reproduce.
struct BaselineRow {
  std::string label;
  std::string dataset;
  /// The entry it was made from, without "label", "seed" and "seeds"; {} for truth and no-contact.
  JsonValue entry = JsonValue::object();
  Tolerance tolerance;
  std::string status = "ok";
  int frames = 0;
  int undefined_frames = 0;
  int frames_not_converged = 0;
  std::vector<int> seeds;  ///< training seeds; empty for solvers that are not trained
  /// Means over the frames: one value, or one for each seed; empty if one is undefined.
  PerMetric<std::vector<double>> metrics;
  std::optional<RelativeTimes> times;
};

/// One metric of the row, which must have values of it, in the form that tolerances take.
BaselineMean mean_of(const BaselineRow& row, Metric metric, const Sensor& sensor);

/// The contents of results/baselines/`experiment`.json.
struct Baseline {
  std::string experiment;
  JsonValue provenance = JsonValue::object();  ///< of the machine, including its "cpu"
  std::string cpu;                             ///< the provenance's
  JsonValue datasets = JsonValue::object();    ///< by name, the canonical JSON of each
  std::vector<BaselineRow> rows;
  /// Metrics that existed when it was stored; later ones are not compared.
  std::vector<Metric> metrics{kMetrics.begin(), kMetrics.end()};
  /// Names of the stored networks and of the short trainings whose images belong to it.
  std::vector<std::string> networks;
  std::vector<std::string> trainings;

  const BaselineRow* find(const ResultRow& row) const;
};

/// The comparison of images of each label, from the solver's registration.
using Comparisons = std::map<std::string, ImageComparison>;
Comparisons comparisons_of(const Experiment& experiment, SolverRegistry& registry);

/// Fewer seeds do not show the spread of a trained solver.
inline constexpr int least_seeds = 3;

/// Makes a baseline of results. Throws std::invalid_argument if the row of a trained solver has
/// fewer than `least_seeds` seeds.
Baseline make_baseline(const Experiment& experiment, std::span<const ResultRow> rows,
                       const Comparisons& comparisons);

/// The first change of what determines the results, "/datasets/test/count was 200 and is 100": of
/// the datasets, or of the entry of a solver that is in both. Empty if nothing changed.
std::string changed_experiment(const Baseline& baseline, const Experiment& experiment);

/// `{"schema": 1, "experiment", "provenance": {"commit", "cpu", ...}, "datasets": {"test": {...},
/// ...}, "rows": [{"label", "dataset", "entry": {...}, "tolerance": {"class", "relative"},
/// "status", "frames", "undefined_frames", "frames_not_converged", "metrics": {"AR": number, or one
/// for each seed, or null, ...}, "seeds": [...], "times": {"latency", "batch_frame"} or null}],
/// "networks": [...], "trainings": [...], "checksum"}`, indented.
std::string to_json_text(const Baseline& baseline);

/// The inverse. Throws InputError naming the place of missing, misspelt or mistyped keys, rows and
/// metrics, or if the checksum does not match: a damaged baseline would let regressions pass.
Baseline read_baseline(const std::filesystem::path& file);

}  // namespace ertbench
