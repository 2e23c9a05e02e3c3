#pragma once

#include <Eigen/Core>
#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/seconds.h"
#include "forward/sheet/sensor.h"
#include "live/live_solver.h"

namespace ertbench {

/// A request to end the stream: by SIGINT, SIGTERM or SIGHUP, which this class handles while it
/// lives, or by a call of `stop`. A second signal of the same kind ends the process at once. Only
/// one object may exist at a time.
class Stop {
 public:
  Stop();
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;
  ~Stop();

  void stop();           ///< from any thread
  bool stopped() const;  ///< by a signal or by `stop`

  enum class Event { readable, time, stopped };
  /// Waits until the descriptor is readable (or its other end is closed), `patience` has passed or
  /// the end is requested; -1: no descriptor.
  Event wait(int descriptor, std::chrono::nanoseconds patience) const;

  /// Waits until PIPE_BUF bytes can be written to the descriptor without blocking; returns false if
  /// the end is requested first.
  bool wait_to_write(int descriptor) const;

 private:
  int asked_ = -1;
};

struct ArrivedFrame {
  std::uint64_t number = 0;         ///< counts the usable frames, from 0
  SteadyClock::time_point arrived;  ///< time of its last byte
  Eigen::RowVectorXd voltages;      ///< [channels] V
};

/// A queue between the thread that reads frames and the one that images them, with one place by
/// default. When it is full the oldest frame is dropped for the newest; if `lossless`, the reader
/// waits instead.
class Mailbox {
 public:
  /// The `first` frames, in a lossless box all of them, wait for their place.
  Mailbox(std::size_t places, bool lossless, std::int64_t first = 0)
      : places_(places), first_(lossless ? INT64_MAX : first) {}

  /// Returns false if the box is closed.
  bool put(ArrivedFrame frame);

  enum class Taken { frame, nothing, closed };
  /// Takes the oldest frame, waiting up to `patience` for one. Frames put before `close` are still
  /// handed out before `closed` is returned.
  Taken take(ArrivedFrame& frame, std::chrono::milliseconds patience);

  /// Accepts no more frames. With `now`, the waiting ones are dropped.
  void close(bool now = false);
  std::uint64_t dropped() const;

 private:
  std::size_t places_;
  std::int64_t first_;  ///< that are still to be taken, and wait for their place
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<ArrivedFrame> frames_;
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

/// Latencies of any number of frames in a fixed memory: counts in classes from 1 µs to 100 s, each
/// 2.3 % wider than the one before. Values outside count in the first or the last class; the
/// largest value is kept exactly.
class LatencyHistogram {
 public:
  static constexpr int classes_per_decade = 100;
  static constexpr int decades = 8;

  void add(double seconds);
  std::uint64_t count() const { return count_; }

  /// The upper end of the class of the nearest rank, capped by the largest latency: at most 2.3 %
  /// too large. Nothing if there is no latency. `share` 0 ... 1.
  std::optional<double> quantile_s(double share) const;

  /// Counts in coarser classes; `per_decade` must divide classes_per_decade.
  std::vector<std::uint64_t> coarse(int per_decade) const;

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(classes_per_decade* decades)> counts_{};
  std::uint64_t count_ = 0;
  double largest_s_ = 0;
};

/// Writes lines of JSON to standard output.
class LineOutput {
 public:
  explicit LineOutput(const Stop& stop) : stop_(stop) {}

  /// Waits for a slow reader. After the end was requested it waits one second in all, so that the
  /// reader may still get the last lines.
  void line(const nlohmann::json& value);
  /// False once a line could not be written: the reader closed the pipe, or see `error`.
  bool open() const { return open_; }
  /// errno of a failed write; 0 if none failed or the reader closed the pipe.
  int error() const { return error_; }

 private:
  bool wait_for_reader();

  const Stop& stop_;
  bool open_ = true;
  int error_ = 0;
  std::optional<std::chrono::steady_clock::time_point> until_;  ///< set once the end is requested
};

/// The record of an answer of version 1, which `--send-format binary` sends as one datagram. All
/// numbers are little-endian.
///
///     offset  type     what
///     0       char[4]  "ERTC"
///     4       uint16   version, 1
///     6       uint16   number of contacts
///     8       uint64   number of the frame
///     16      float64  time of its arrival since the stream began, s
///     24      float32  latency from its arrival to the answer, s
///     28      uint8    status, 0: ok (FrameStatus)
///     29      uint8    reasons, bits (FrameReason, FrameFault)
///     30      uint16   0
///     32      uint64   dead electrodes, bit e for electrode e
///     40      contacts, the strongest first, six float32 each: x and y in mm from the sheet's
///             centre, strength in S/m mm2, peak in S/m, area in mm2, force in N or NaN
std::string binary_record(const LiveAnswer& answer, const Sensor& sensor, std::uint64_t frame,
                          double time_s, double latency_s);

}  // namespace ertbench
