#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "bench/score/metrics.h"

namespace ertbench {

struct SpeedQuestion {
  std::string dataset;
  std::vector<std::string> labels;  ///< of the rows, in order
  Metric metric = Metric::relative_error;
  std::vector<double> budgets_us;  ///< time limits for one frame, each with a recommendation
  std::optional<RightSizing> right_sizing;
  std::vector<std::string> break_even_against;  ///< labels that longer fits are compared with
};

/// Only `ok` configurations may be recommended.
enum class Standing {
  ok,
  not_converged,  ///< more than 1 % of its frames did not converge, or have no usable image
  failed,         ///< the trial crashed, ran out of time, diverged, or was not run
};

/// One configuration on the chart of speed and accuracy.
struct SpeedPoint {
  std::string label;
  std::string type;
  std::string family;
  Standing standing = Standing::ok;
  std::string remark;                      ///< why it is not ok
  std::optional<LatencySummary> latency;   ///< µs
  std::optional<double> error;             ///< mean over the frames
  std::optional<Interval> error_ci95;      ///< of the mean
  std::optional<double> validation_error;  ///< mean over the validation set
  /// The error that decides recommendations: the mean over the validation set if that was scored,
  /// so that nothing is chosen on the frames it is reported on; otherwise `error`.
  std::optional<double> choice_error;
  std::optional<double> frames_per_s;  ///< with a batch
  std::optional<double> fit_s;
  std::optional<double> peak_rss_mb;
  bool frontier = false;        ///< none as fast has an error as small, within a thousandth
  bool batch_frontier = false;  ///< like `frontier`, for frames per second in batches
  bool right_size = false;      ///< the smallest of its family that is good enough

  bool measured() const { return latency && error; }
  bool timed_to_contacts() const { return latency && latency->contacts_p99; }
};

/// The smallest setting of a family that is good enough, by the validation set alone.
struct RightSize {
  std::string family;
  std::size_t best = 0;    ///< index of the point with the least validation error
  std::size_t chosen = 0;  ///< index of the first in the file's order within the margin of it
};

/// A recommendation, of one of three kinds: the fastest configuration whose choice_error is at most
/// (1 + margin) times the least; or the one with the least choice_error of those whose p99, to the
/// image or to the contacts, keeps within the budget; of several within a thousandth of it the
/// fastest.
struct SpeedChoice {
  std::optional<double> margin = {};
  std::optional<double> budget_us = {};
  std::optional<double> contacts_budget_us = {};
  std::optional<std::size_t> point = {};
};

/// Numbers of frames after which the faster frames of a configuration repay its longer fit.
struct BreakEven {
  std::string reference;                      ///< label of the configuration to compare with
  std::vector<std::optional<double>> frames;  ///< [points]; none: never, or not measured
};

/// Everything that the chart of speed and accuracy and its tables show.
struct SpeedAccuracy {
  Metric metric = Metric::relative_error;
  std::string dataset;
  std::vector<SpeedPoint> points;  ///< in the order of the experiment file
  std::optional<double> nothing;   ///< the mean error of the empty image
  /// Mean error, with its interval, of the best known estimator under the test set's own prior, if
  /// `ertbench limit` computed it.
  std::optional<double> limit;
  std::optional<Interval> limit_ci95;
  int limit_frames = 0;
  int limit_unresolved = 0;            ///< if not 0, the limit may lie below the line
  std::vector<RightSize> right_sizes;  ///< of families with two settings or more
  std::optional<RightSizing> right_sizing;
  /// Within 1, 5 and 20 %, then the budgets asked for, then five to contacts if timed.
  std::vector<SpeedChoice> choices;
  bool chosen_on_validation = false;  ///< otherwise on the test set
  std::vector<BreakEven> break_even;
  int batch = 0;  ///< frames in a call for frames_per_s
};

/// Evaluates the rows asked for. A configuration that failed or did not converge has a point, but
/// is neither on the frontier nor recommended.
SpeedAccuracy speed_accuracy_of(const SpeedQuestion& question, std::span<const ResultRow> rows);

/// The entry of summary.json: `{"dataset", "metric", "chosen_on", "frontier": [labels],
/// "within_margin": [{"margin", "label"}], "within_budget": [{"budget_us", "to_contacts",
/// "label"}], "right_sizes":
/// [{"family", "best", "chosen"}], "break_even_frames": {reference: {label: frames or null}}}`.
nlohmann::json to_json(const SpeedAccuracy& chart);

/// "350 ns", "3.90 µs", "2.07 ms", "1.50 s", "4.9 min".
std::string time_text(double microseconds);
/// "637 k", "2.10 k", "42", "40.7 G".
std::string rate_text(double per_second);

/// The numbers of one configuration in lines, for its tooltip.
std::string description(const SpeedPoint& point, const SpeedAccuracy& chart);

}  // namespace ertbench
