#pragma once

#include <vector>

#include "bench/load/offered_load.h"
#include "core/arrays.h"
#include "core/seconds.h"
#include "solvers/solver.h"

namespace ertbench {

/// A solver and the steady clock: from raw voltages to the finished image, one frame at a time, on
/// the calling thread. It waits by looking at the clock, so that no waking up is in the latencies
/// and that the processor's time, which then goes on as the clock does, tells how much of it the
/// machine spent on others.
class TimedServer : public LoadServer {
 public:
  /// `voltages` [frames, channels] V, taken in turn; `reference` [channels] V. All must outlive
  /// this.
  TimedServer(const Solver& solver, const Frames& voltages, const Eigen::RowVectorXd& reference,
              int pixels);

  double now_s() override;
  void wait_until(double time_s) override;
  void serve(std::size_t frame) override;

  /// Times of so many frames, after some that only warm up, s.
  std::vector<double> service_s(std::size_t frames);

  /// Share of the time since the making in which this thread was not running: the machine was busy
  /// with something else.
  double lost_share() const;

 private:
  const Solver& solver_;
  const Frames& voltages_;
  const Eigen::RowVectorXd& reference_;
  Frames change_;
  Images image_;
  SteadyClock::time_point start_;
  double start_cpu_s_;
};

}  // namespace ertbench
