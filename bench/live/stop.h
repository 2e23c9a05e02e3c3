#pragma once

#include <chrono>

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

}  // namespace ertbench
