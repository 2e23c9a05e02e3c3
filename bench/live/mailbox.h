#pragma once

#include <Eigen/Core>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>

#include "core/seconds.h"

namespace ertbench {

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

}  // namespace ertbench
