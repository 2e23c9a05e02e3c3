#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

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

}  // namespace ertbench
