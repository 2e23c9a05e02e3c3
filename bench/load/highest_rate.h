#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "bench/load/offered_load.h"

namespace ertbench {

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
