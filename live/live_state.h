#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "live/line_output.h"
#include "live/live_solver.h"
#include "live/live_source.h"

namespace ertbench {

/// Counts of frames and of what became of them.
struct LiveCounts {
  std::uint64_t came = 0;  ///< usable frames
  std::uint64_t answered = 0;
  std::uint64_t dropped = 0;  ///< replaced by a newer one, or discarded by the operating system
  std::array<std::uint64_t, all_damages.size()> damaged{};
  std::uint64_t late = 0;  ///< answered after the deadline

  std::uint64_t all_damaged() const;
};

/// The constants of a stream.
struct LiveHeading {
  std::string solver;  ///< type or label
  std::string input;
  double deadline_s = 0;  ///< 0: none
  Sensor sensor;
};

/// The newest state of a stream, written by the solver's thread and read by those of clients. The
/// writer never waits for a reader; a slow reader misses states.
class LiveState {
 public:
  explicit LiveState(LiveHeading heading) : heading_(std::move(heading)) {}

  /// Called by the one writer. Updates counts and latency always, the answer only if the last one
  /// was shown long enough ago.
  void update(const LiveCounts& counts, double time_s);
  void update(const LiveCounts& counts, double time_s, const ArrivedFrame& frame,
              const LiveAnswer& answer, double latency_s);
  /// Sets for how long the sender has been silent, s; 0 if it is not.
  void set_silence(double silent_s);
  void finish();  ///< no more states

  /// The state as JSON on one line.
  std::string json() const;
  /// Waits up to a second for a state newer than `version` and returns the newest version.
  std::uint64_t wait_for_newer(std::uint64_t version) const;
  bool finished() const { return finished_; }

  std::atomic<int> watchers = 0;  ///< clients that follow it

 private:
  void show();  ///< publishes a new version; the mutex must be locked

  LiveHeading heading_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::uint64_t version_ = 0;
  std::atomic<bool> finished_ = false;
  LiveCounts counts_;
  LatencyHistogram latency_;
  double time_s_ = 0;
  double shown_s_ = -1;
  double answer_s_ = -1;  ///< when the answer was taken
  double silent_s_ = 0;
  double latency_s_ = 0;
  std::uint64_t frame_ = 0;
  bool any_answer_ = false;
  LiveAnswer answer_;
  /// [(time, came, answered)] of the last seconds, for the rates.
  std::vector<std::array<double, 3>> history_;
};

/// "ok", "not converged", "undefined", "suspect".
const char* name_of(FrameStatus status);
/// ["dead electrode", ...]
nlohmann::json reasons_json(std::uint8_t reasons);

/// An answer as it is written to standard output and shown on the page:
///
///     {"status", "reasons", "dead_electrodes", "contacts": [{"x_mm", "y_mm", "strength", "peak",
///      "area_mm2", "force_N"}], "tracks": [{"id", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "seen"}],
///      "force_N", "signal", "alarm"}
///
/// Positions are in mm from the sheet's centre and tracks confirmed ones; "strength" in S/m mm²,
/// "peak" and "signal" (the largest |δσ|) in S/m. The frame's force is divided among the contacts
/// by strength. A missing value is null.
nlohmann::json answer_json(const LiveAnswer& answer, const Sensor& sensor);

/// `{"came", "answered", "dropped", "late", "damaged": {"wrong length", ...}}`
nlohmann::json counts_json(const LiveCounts& counts);

/// `{"least_s", "per_decade", "counts"}`: logarithmic classes from `least_s` on.
nlohmann::json histogram_json(const LatencyHistogram& latency);

/// `{"p50", "p99", "max"}`, µs.
nlohmann::json latency_json(const LatencyHistogram& latency);

}  // namespace ertbench
