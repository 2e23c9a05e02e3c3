#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/score/metrics.h"
#include "core/build_stamp.h"
#include "core/json.h"

namespace ertbench {

/// Where and beside what a row's times were measured.
struct TimingPlace {
  std::string cpu;   ///< the processor's name; empty where an earlier version did not say
  std::string node;  ///< the machine's
  /// Cores that other processes kept busy meanwhile, the most of the rounds.
  double busy_cores = 0;

  bool operator==(const TimingPlace&) const = default;
};

/// From how many cores on others are said to have disturbed the clock.
inline constexpr double least_disturbing_cores = 0.25;

/// When records were made. Dates are ISO 8601 in UTC, so that their order is that of the text.
struct DateRange {
  std::string first;  ///< empty where there are none
  std::string last;

  void add(const std::string& date) {
    if (date.empty()) return;
    if (first.empty() || date < first) first = date;
    if (last.empty() || date > last) last = date;
  }
};

/// By stage, and of "fits": the builds that made the records of a result, each once.
using Builds = std::map<std::string, std::vector<BuildStamp>>;

/// For a table's foot: "build: commit 0123456789ab, program 01234567.", of several builds each with
/// what it made; empty where there is none.
std::string text_of(const Builds& builds);

/// `{"accuracy": [{"commit", ...}], "fits": [...], ...}`
nlohmann::json to_json(const Builds& builds);
/// The inverse. What is no stamp is left out.
Builds builds_from_json(const nlohmann::json& builds);

/// Time from raw voltages to the finished image of one frame, batch 1, one thread; µs.
struct LatencySummary {
  double p50 = 0;
  double p99 = 0;
  double max = 0;
  /// The medians of the rounds in which the frames were timed, other solvers' rounds between them.
  std::vector<double> p50_of_rounds = {};
  /// relative_latency() of each round: in units of a fixed piece of work of the same process.
  std::vector<double> relative_of_rounds = {};
  /// The part of p50 that the way to the solver's own process and back takes: the median of the
  /// same bytes through a program that only answers. Of a solver in a process of its own alone.
  std::optional<double> pipe = {};
  /// Time from raw voltages to the contacts, in a pass of its own; none in older results.
  std::optional<double> contacts_p50 = {};
  std::optional<double> contacts_p99 = {};

  bool operator==(const LatencySummary&) const = default;
};

/// The values that there are.
std::vector<double> those_there(const std::vector<std::optional<double>>& values);

/// Results of the trainings of one solver, one for each seed.
struct SeedSpread {
  std::vector<int> values;                              ///< the seeds whose numbers are in the row
  PerMetric<std::vector<std::optional<double>>> means;  ///< [seeds]
  /// Sample standard deviation of the means; without a value where fewer than two have one.
  PerMetric<std::optional<double>> deviation;
  std::vector<std::optional<double>> fit_s;  ///< [seeds]
  /// Parameters that differ between seeds: a list with an object for each.
  JsonValue parameters = JsonValue::array();

  /// The median of `fit_s`, which one training on a busy machine does not move; no value without.
  std::optional<double> usual_fit_s() const;
};

/// How far a row is from what any method could have: the mean relative error of δσ over that of the
/// limit, both on the limit's frames.
struct OverLimit {
  double ratio = 0;
  Interval ci95;  ///< bootstrap over the frames, both means of the same
  int frames = 0;
};

/// The builds that made a row's numbers, each once; of a row without a solver the one that scored.
struct RowBuilds {
  std::vector<BuildStamp> scored;
  std::vector<BuildStamp> fitted;
  std::vector<BuildStamp> timed;
};

/// Results of one solver on one test set: an entry of summary.json's "rows". What was not measured,
/// or came out not finite, has no value and is null in the JSON.
struct ResultRow {
  std::string label;
  std::string type;                            ///< the solver's, or "no-contact", "truth"
  std::string dataset;                         ///< name of the test set
  std::string status = "ok";                   ///< or "failed", "timed out", "crashed", ...
  std::string message;                         ///< why it is not ok; may have several lines
  JsonValue parameters = JsonValue::object();  ///< the parameters in use, the first seed's
  int frames = 0;
  int undefined_frames = 0;      ///< frames without a usable image
  int frames_not_converged = 0;  ///< frames whose image is not the one that was asked for
  int suspect_frames = 0;  ///< frames that the solver would not trust; they are in all averages
  PerMetric<MetricSummary> metrics;
  /// Scores on the validation set, where the experiment chooses sizes by it.
  std::optional<PerMetric<MetricSummary>> validation;
  std::optional<OverLimit> over_limit;  ///< where there is a limit
  std::optional<LatencySummary> latency_us;
  /// Time of calibration_us() in the same process, a unit that latencies on different machines
  /// can be compared in; µs.
  std::optional<double> calibration_us;
  std::optional<TimingPlace> timed_on;  ///< none where an earlier version did not say
  std::optional<double> frames_per_s;   ///< throughput, with a batch
  int throughput_batch = 0;             ///< frames in that batch; 0 where it was not measured
  std::optional<double> fit_s;          ///< of the seeds' the median
  std::optional<double> peak_rss_mb;
  std::optional<SeedSpread> seeds;  ///< where the experiment lists seeds
  RowBuilds build;
  std::string family;  ///< shared by the rows that differ by one setting alone; else the label
  JsonValue sweep;     ///< the values of a sweep; null without one

  bool ok() const { return status == "ok"; }
};

/// An entry of "rows" as docs/results.md describes it; "build" is that of the scores, with the
/// lists "scored", "fitted" and "timed".
nlohmann::json to_json(const ResultRow& row);

/// The inverse. Reads what earlier versions wrote, too: metrics that there were not have no values,
/// a row without a family is one of its own, without suspect frames it has none. Throws InputError
/// naming the place of what else is missing, misspelt or of another type.
ResultRow result_row_from_json(JsonObject object);

/// The row of a label and a test set; null where there is none.
const ResultRow* find_row(std::span<const ResultRow> rows, const std::string& label,
                          const std::string& dataset);

/// How many of a row's training runs came to rest within their budget of epochs.
struct Convergence {
  int runs = 0;           ///< one for each seed; 0 where nothing was trained
  int not_converged = 0;  ///< of these, the runs whose best epoch is the last that was allowed

  bool all() const { return not_converged == 0; }
};

/// Reads it from what the trainings reported in the row's parameters, `"training": {"best_epoch",
/// "converged"}`; where an earlier program did not say `"converged"`, from `"epochs"` beside it.
Convergence convergence_of(const ResultRow& row);

}  // namespace ertbench
