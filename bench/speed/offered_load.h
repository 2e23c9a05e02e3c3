#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/arrays.h"
#include "core/seconds.h"
#include "solvers/solver.h"

namespace ertbench {

/// How frames arrive: at equal distances, or independently of each other with exponentially
/// distributed ones (a Poisson process), as events do that know nothing of each other.
enum class Arrivals { fixed, poisson };
inline constexpr Arrivals all_arrivals[] = {Arrivals::fixed, Arrivals::poisson};
const char* name_of(Arrivals arrivals);

/// When `count` frames arrive, s from the beginning, ascending. `seed` is of no account at a fixed
/// rate.
std::vector<double> arrival_times(Arrivals arrivals, double rate_per_s, std::size_t count,
                                  std::uint64_t seed);

/// What works on frames, one after the other, and the clock beside it: a solver and the steady
/// clock, or both simulated.
class LoadServer {
 public:
  virtual ~LoadServer() = default;
  virtual double now_s() = 0;
  virtual void wait_until(double time_s) = 0;
  /// Works on a frame; the clock goes on meanwhile. `frame` counts from 0.
  virtual void serve(std::size_t frame) = 0;
};

/// What is asked of a run.
struct LoadDeadline {
  double seconds = 0.01;  ///< from a frame's arrival to its finished image
  double share = 0.99;    ///< of the frames that must keep it

  /// Frames of `count` that may miss it: the nearest rank of `share` must keep it.
  std::size_t misses_allowed(std::size_t count) const;
};

struct LoadRun {
  std::vector<double> latency_s;  ///< of the frames that were worked on, in order
  double service_s = 0;           ///< mean time that the server itself took
  std::size_t missed = 0;         ///< frames later than the deadline
  bool broken_off = false;        ///< too many had missed it: the rest was not worked on
  bool kept = false;
};

/// Offers frames to a server with room for any number of waiting ones, first come, first served.
/// Arrivals are moments that are laid down before, not when a generator got round to them: a frame
/// that waits because the one before took long has waited. Ends early where the deadline cannot be
/// kept any more. A rate above what the server can do, which the queue of a short run would hide,
/// keeps no deadline.
LoadRun offer_load(const std::vector<double>& arrivals_s, const LoadDeadline& deadline,
                   LoadServer& server);

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

/// How a rate is searched for.
struct RateSearch {
  Arrivals arrivals = Arrivals::poisson;
  LoadDeadline deadline;
  std::size_t least_frames = 1000;  ///< of a run; 662 are the least with which p99 has a meaning
  /// A run lasts so many deadlines at least: else the queue of an overloaded server would fit in.
  double least_deadlines = 50;
  double resolution = 1.03;  ///< between the rate that was kept and the next that was not
  std::uint64_t seed = 1;    ///< of the arrivals; each run has draws of its own
};

/// The highest rate that kept the deadline, and what was seen there.
struct KeptRate {
  std::optional<double> per_s;  ///< nothing: no rate does
  double p99_s = 0;             ///< of the search's own run at this rate (RateSearch's share)
  /// The same in a run with other arrivals, as a rate that is the best of several runs owes some of
  /// it to luck.
  double confirmed_p99_s = 0;
  bool confirmed = false;  ///< whether the deadline was kept then, too
  double utilisation = 0;  ///< share of the time that the server worked
  std::size_t frames = 0;  ///< of a run at this rate
  int runs = 0;            ///< that the search took
};

/// Bisects the rate on a logarithmic scale. `service_s` are times that the server took, measured
/// before: the search begins where a queue simulated with them would end.
KeptRate highest_rate(const RateSearch& search, const std::vector<double>& service_s,
                      LoadServer& server);

/// The same for a server that only exists as times of service, taken in turn.
class SimulatedServer : public LoadServer {
 public:
  explicit SimulatedServer(std::vector<double> service_s) : service_s_(std::move(service_s)) {}
  double now_s() override { return now_s_; }
  void wait_until(double time_s) override { now_s_ = time_s; }
  void serve(std::size_t frame) override { now_s_ += service_s_[frame % service_s_.size()]; }

 private:
  std::vector<double> service_s_;
  double now_s_ = 0;
};

}  // namespace ertbench
