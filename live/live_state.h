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

/// How many frames came, and what became of them.
struct LiveCounts {
  std::uint64_t came = 0;  ///< usable ones
  std::uint64_t answered = 0;
  std::uint64_t dropped = 0;  ///< for a newer one, or by the system before we read it
  std::array<std::uint64_t, all_damages.size()> damaged{};
  std::uint64_t late = 0;  ///< answered after the deadline

  std::uint64_t all_damaged() const;
};

/// What does not change while a stream runs.
struct LiveHeading {
  std::string solver;  ///< its type or label
  std::string input;
  double deadline_s = 0;  ///< 0: none
  Sensor sensor;
};

/// The newest state of a stream, for whoever looks at it: what is written by the solver's thread
/// and read by those of clients. The writer copies some kilobytes now and then and never waits for
/// a reader to have read; a reader that is slow misses states.
class LiveState {
 public:
  explicit LiveState(LiveHeading heading) : heading_(std::move(heading)) {}

  /// By the one writer. Counts and the latency always; the answer, where there is one, only if the
  /// last answer was shown long enough ago.
  void update(const LiveCounts& counts, double time_s);
  void update(const LiveCounts& counts, double time_s, const ArrivedFrame& frame,
              const LiveAnswer& answer, double latency_s);
  /// The sender: for how long it has been silent, s; 0 while it is not.
  void set_silence(double silent_s);
  void finish();  ///< no more states

  /// As JSON, on one line.
  std::string json() const;
  /// Waits until there is a state newer than `version`, for a second at most, and returns its
  /// version.
  std::uint64_t wait_for_newer(std::uint64_t version) const;
  bool finished() const { return finished_; }

  std::atomic<int> watchers = 0;  ///< clients that follow it

 private:
  void show();  ///< with the lock: there is a new version

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
  /// [(time, came, answered)] at most some seconds back, for the rates.
  std::vector<std::array<double, 3>> history_;
};

/// "ok", "not converged", "undefined", "suspect".
const char* name_of(FrameStatus status);
/// ["a dead electrode", ...]
nlohmann::json reasons_json(std::uint8_t reasons);

/// What is said of an answer, on standard output and on the page:
///
///     {"status", "reasons", "dead_electrodes", "contacts": [{"x_mm", "y_mm", "strength", "peak",
///      "area_mm2", "force_N"}], "tracks": [{"id", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "seen"}],
///      "force_N", "signal", "alarm"}
///
/// Places in mm from the sheet's centre, tracks that are confirmed; "strength" in S/m mm², "peak"
/// and "signal" (the largest |δσ|) in S/m. A contact's force is its share of the frame's by
/// strength. null where there is no value.
nlohmann::json answer_json(const LiveAnswer& answer, const Sensor& sensor);

/// `{"came", "answered", "dropped", "late", "damaged": {"wrong length", ...}}`
nlohmann::json counts_json(const LiveCounts& counts);

/// `{"least_s", "per_decade", "counts"}`: classes from `least_s` on, equally wide on a logarithmic
/// scale.
nlohmann::json histogram_json(const LatencyHistogram& latency);

/// `{"p50", "p99", "max"}`, µs.
nlohmann::json latency_json(const LatencyHistogram& latency);

}  // namespace ertbench
