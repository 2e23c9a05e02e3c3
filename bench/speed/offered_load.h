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

/// Arrival of frames: at equal intervals, or as a Poisson process of independent events.
enum class Arrivals { fixed, poisson };
inline constexpr Arrivals all_arrivals[] = {Arrivals::fixed, Arrivals::poisson};
const char* name_of(Arrivals arrivals);

/// Arrival times of `count` frames, s from the beginning, ascending. `seed` does not matter for
/// fixed arrivals.
std::vector<double> arrival_times(Arrivals arrivals, double rate_per_s, std::size_t count,
                                  std::uint64_t seed);

/// A server that processes frames one by one, with its clock: a solver and the steady clock, or a
/// simulation of both.
class LoadServer {
 public:
  virtual ~LoadServer() = default;
  virtual double now_s() = 0;
  virtual void wait_until(double time_s) = 0;
  /// Processes a frame, during which the clock advances. `frame` counts from 0.
  virtual void serve(std::size_t frame) = 0;
};

struct LoadDeadline {
  double seconds = 0.01;  ///< from a frame's arrival to its finished image
  double share = 0.99;    ///< of the frames that must keep it

  /// Number of `count` frames that may miss it: the nearest rank of `share` must keep it.
  std::size_t misses_allowed(std::size_t count) const;
};

struct LoadRun {
  std::vector<double> latency_s;  ///< of the processed frames, in order
  double service_s = 0;           ///< mean service time
  std::size_t missed = 0;         ///< frames later than the deadline
  bool broken_off = false;        ///< too many missed it, so the rest was not processed
  bool kept = false;
};

/// Offers frames to a server with an unlimited first-come, first-served queue. Arrival times are
/// fixed beforehand, so that a frame delayed by the one before counts its waiting time. The run
/// ends early if the deadline cannot be kept any more. A rate above the server's capacity, which
/// the queue of a short run would hide, keeps no deadline.
LoadRun offer_load(const std::vector<double>& arrivals_s, const LoadDeadline& deadline,
                   LoadServer& server);

/// A solver and the steady clock: from raw voltages to the finished image, one frame at a time, on
/// the calling thread. Waiting is busy, so that latencies include no wake-up time and the thread's
/// processor time shows how much time other processes took.
class TimedServer : public LoadServer {
 public:
  /// `voltages` [frames, channels] V, taken in turn; `reference` [channels] V. All must outlive
  /// this.
  TimedServer(const Solver& solver, const Frames& voltages, const Eigen::RowVectorXd& reference,
              int pixels);

  double now_s() override;
  void wait_until(double time_s) override;
  void serve(std::size_t frame) override;

  /// Service times of a number of frames, after a warm-up, s.
  std::vector<double> service_s(std::size_t frames);

  /// Share of the time since construction in which this thread was not running.
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

struct RateSearch {
  Arrivals arrivals = Arrivals::poisson;
  LoadDeadline deadline;
  std::size_t least_frames = 1000;  ///< of a run; p99 needs 662
  /// Shortest run in deadlines; the queue of an overloaded server could fit into a shorter one.
  double least_deadlines = 50;
  double resolution = 1.03;  ///< ratio of the lowest rate that failed to the highest that was kept
  std::uint64_t seed = 1;    ///< of the arrivals; each run draws its own
};

/// The highest rate that kept the deadline, with measurements at that rate.
struct KeptRate {
  std::optional<double> per_s;  ///< nothing if no rate kept it
  double p99_s = 0;             ///< latency in the search (quantile: the deadline's share)
  double confirmed_p99_s = 0;   ///< latency in a second run with other arrivals
  bool confirmed = false;       ///< the second run kept the deadline too
  double utilisation = 0;       ///< share of the time that the server worked
  std::size_t frames = 0;       ///< of a run at this rate
  int runs = 0;                 ///< number of runs of the search
};

/// Bisects the rate on a logarithmic scale. `service_s` are measured service times; the search
/// begins at the highest rate of a queue simulated with them.
KeptRate highest_rate(const RateSearch& search, const std::vector<double>& service_s,
                      LoadServer& server);

/// A simulated server with given service times, taken in turn.
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
