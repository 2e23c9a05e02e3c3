#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "bench/bootstrap.h"
#include "bench/metrics.h"

namespace ertbench {

class JsonObject;

/// Time from raw voltages to the finished image of one frame, batch 1, one thread; µs.
struct LatencySummary {
  double p50 = 0;
  double p99 = 0;
  double max = 0;

  bool operator==(const LatencySummary&) const = default;
};

/// What one solver did on one test set: an entry of summary.json's "rows". What was not measured,
/// or came out not finite, has no value and is null in the JSON.
struct ResultRow {
  std::string label;
  std::string type;                    ///< the solver's, or "no-contact", "truth"
  std::string dataset;                 ///< name of the test set
  std::string status = "ok";           ///< or "failed", "timed out", "crashed", ...
  std::string message;                 ///< why it is not ok; may have several lines
  std::string parameters_json = "{}";  ///< the parameters in use, JSON text
  int frames = 0;
  int undefined_frames = 0;      ///< frames without a usable image
  int frames_not_converged = 0;  ///< frames whose image is not the one that was asked for
  PerMetric<MetricSummary> metrics;
  std::optional<LatencySummary> latency_us;
  std::optional<double> frames_per_s;  ///< throughput, with a batch
  int throughput_batch = 0;            ///< frames in that batch; 0 where it was not measured
  std::optional<double> fit_s;
  std::optional<double> peak_rss_mb;

  bool ok() const { return status == "ok"; }
};

/// `{"label", "type", "dataset", "status", "message", "parameters", "frames", "undefined_frames",
/// "frames_not_converged", "metrics": {"AR": {"mean", "ci95": [low, high], "median", "count",
/// "undefined"}, ...}, "latency_us": {"p50", "p99", "max"}, "frames_per_s", "throughput_batch",
/// "fit_s", "peak_rss_mb"}`. Throws std::invalid_argument where `parameters_json` is not JSON.
nlohmann::json to_json(const ResultRow& row);

/// The inverse. Throws InputError naming the place of what is missing, misspelt or of another type.
ResultRow result_row_from_json(JsonObject object);

}  // namespace ertbench
