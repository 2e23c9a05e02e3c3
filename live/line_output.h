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
#include <vector>

#include "core/seconds.h"

namespace ertbench {

/// The end of a stream that others ask for: SIGINT, SIGTERM and SIGHUP, which from its making on
/// end the process in an orderly way, and whoever calls `stop`. A second signal of the same kind
/// ends the process at once. There is one at a time.
class Stop {
 public:
  Stop();
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;
  ~Stop();

  void stop();           ///< from any thread
  bool stopped() const;  ///< by a signal or by `stop`

  enum class Event { readable, time, stopped };
  /// Waits until the descriptor can be read (or its other end is gone), for so long, or for the
  /// end; -1: no descriptor.
  Event wait(int descriptor, std::chrono::nanoseconds patience) const;

  /// Waits until PIPE_BUF bytes can be written to the descriptor without waiting any more; false
  /// where the end comes first.
  bool wait_to_write(int descriptor) const;

 private:
  int asked_ = -1;
};

/// A frame as it came.
struct ArrivedFrame {
  std::uint64_t number = 0;         ///< of the usable frames, from 0
  SteadyClock::time_point arrived;  ///< when its last byte was there
  Eigen::RowVectorXd voltages;      ///< [channels] V
};

/// Between whoever reads frames and whoever images them: a few places, by default one. Where all
/// are taken the oldest frame is dropped for the newest, or, lossless, the reader waits.
class Mailbox {
 public:
  Mailbox(std::size_t places, bool lossless) : places_(places), lossless_(lossless) {}

  /// Returns false where the box is closed.
  bool put(ArrivedFrame frame);

  enum class Taken { frame, nothing, closed };
  /// The oldest frame there is; waits for one for so long. What was put before `close` is taken
  /// before "closed" is said.
  Taken take(ArrivedFrame& frame, std::chrono::milliseconds patience);

  /// No more frames are put. With `now`, none is taken either.
  void close(bool now = false);
  std::uint64_t dropped() const;

 private:
  std::size_t places_;
  bool lossless_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<ArrivedFrame> frames_;
  std::uint64_t dropped_ = 0;
  bool closed_ = false;
};

/// Latencies of any number of frames in a fixed memory: counts in classes that are equally wide on
/// a logarithmic scale, from 1 µs to 100 s, each 2.3 % wider than the one before. What is outside
/// counts in the first or the last class; the largest is kept as it is.
class LatencyHistogram {
 public:
  static constexpr int classes_per_decade = 100;
  static constexpr int decades = 8;

  void add(double seconds);
  std::uint64_t count() const { return count_; }
  double largest_s() const { return largest_s_; }

  /// The upper end of the class in which the nearest rank lies, the largest where that is less:
  /// at most 2.3 % too much. Nothing where there is no latency. `share` 0 ... 1.
  std::optional<double> quantile_s(double share) const;

  /// Counts by coarser classes, `per_decade` of them, which must divide classes_per_decade.
  std::vector<std::uint64_t> coarse(int per_decade) const;

 private:
  std::array<std::uint64_t, static_cast<std::size_t>(classes_per_decade* decades)> counts_{};
  std::uint64_t count_ = 0;
  double largest_s_ = 0;
};

class Stop;

/// Lines of JSON on standard output.
class LineOutput {
 public:
  explicit LineOutput(const Stop& stop) : stop_(stop) {}

  /// Waits for a reader that is slow; once the stream was told to end, for a second in all, so that
  /// it may still have the last lines.
  void line(const nlohmann::json& value);
  /// Whether all lines got out; nobody reads them any more, else, or `error` says why not.
  bool open() const { return open_; }
  /// Of the system, where lines could not be written though somebody might read them; 0 else.
  int error() const { return error_; }

 private:
  bool wait_for_reader();

  const Stop& stop_;
  bool open_ = true;
  int error_ = 0;
  std::optional<std::chrono::steady_clock::time_point> until_;  ///< once it was told to end
};

}  // namespace ertbench
