#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bench/check/tolerance.h"
#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"

namespace ertbench {

class SolverRegistry;

/// Times that outlast the machine they were measured on, roughly: as multiples of calibration_us()
/// in the same process.
struct RelativeTimes {
  double latency = 0;      ///< of one frame, the median of the rounds' relative_latency()
  double batch_frame = 0;  ///< of one frame of a batch

  bool operator==(const RelativeTimes&) const = default;
};

/// Nothing where the row was not timed.
std::optional<RelativeTimes> relative_times(const ResultRow& row);

/// A row as it is to come out again.
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
  std::vector<int> seeds;  ///< that a trained solver was trained with; else empty
  /// Means over the frames: one value, or one for each seed; none where one is undefined.
  PerMetric<std::vector<double>> metrics;
  std::optional<RelativeTimes> times;

  bool is(const ResultRow& row) const { return label == row.label && dataset == row.dataset; }
};

/// One metric of the row, which must have values of it, as tolerances are told it.
BaselineMean mean_of(const BaselineRow& row, Metric metric, const Sensor& sensor);

/// What `ertbench check` compares with: results/baselines/`experiment`.json.
struct Baseline {
  std::string experiment;
  JsonValue provenance = JsonValue::object();  ///< of the machine, its "cpu" among it
  std::string cpu;                             ///< the same
  JsonValue datasets = JsonValue::object();    ///< by name, the canonical JSON of each
  std::vector<BaselineRow> rows;
  /// What was scored when it was stored; metrics that came later are not compared.
  std::vector<Metric> metrics{kMetrics.begin(), kMetrics.end()};
  /// The stored networks and the short trainings beside it, by name, whose images belong to it.
  std::vector<std::string> networks;
  std::vector<std::string> trainings;

  const BaselineRow* find(const ResultRow& row) const;
};

/// How the images of the rows of each label are compared, as the solver's registration says.
using Comparisons = std::map<std::string, ImageComparison>;
Comparisons comparisons_of(const Experiment& experiment, SolverRegistry& registry);

/// Labels of the rows that are compared by seeds: their solvers are trained.
std::set<std::string> trained_labels(const Comparisons& comparisons);

/// Fewer say nothing about the spread of a trained solver.
inline constexpr int least_seeds = 3;

/// A baseline of these results. Throws std::invalid_argument where the row of a trained solver has
/// fewer than `least_seeds` seeds.
Baseline make_baseline(const Experiment& experiment, std::span<const ResultRow> rows,
                       const Comparisons& comparisons);

/// Where what determines the results is not what it was, "/datasets/test/count was 200 and is 100":
/// the datasets, or the entry of a solver that stands in both. Empty where nothing changed.
std::string changed_experiment(const Baseline& baseline, const Experiment& experiment);

/// `{"schema": 1, "experiment", "provenance": {"commit", "cpu", ...}, "datasets": {"test": {...},
/// ...}, "rows": [{"label", "dataset", "entry": {...}, "tolerance": {"class", "relative"},
/// "status", "frames", "undefined_frames", "frames_not_converged", "metrics": {"AR": number, or one
/// for each seed, or null, ...}, "seeds": [...], "times": {"latency", "batch_frame"} or null}],
/// "networks": [...], "trainings": [...], "checksum"}`, indented.
std::string to_json_text(const Baseline& baseline);

/// The inverse. Throws InputError naming the place of what is missing, misspelt or of another type,
/// of rows or metrics that are not there, and of a checksum that is not that of the content: what a
/// baseline has lost would pass for what is as it was.
Baseline read_baseline(const std::filesystem::path& file);

}  // namespace ertbench
