#include "bench/load/highest_rate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/quantile.h"

namespace ertbench {
namespace {

/// Rates far below what a server can do keep a deadline or no rate does.
constexpr double lowest_utilisation = 0.01;
constexpr double first_step = 1.15;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Tries rates on one server and keeps the highest that did.
class RateTrials {
 public:
  RateTrials(const RateSearch& search, LoadServer& server) : search_(search), server_(server) {}

  std::size_t frames_at(double rate) const {
    const double lasting = search_.least_deadlines * search_.deadline.seconds * rate;
    return std::max(search_.least_frames, static_cast<std::size_t>(std::ceil(lasting)));
  }

  LoadRun run(double rate) {
    // Every run has arrivals of its own: the best of several on the same ones would be theirs.
    const std::uint64_t seed = search_.seed * 1000003 + static_cast<std::uint64_t>(++runs_);
    return offer_load(arrival_times(search_.arrivals, rate, frames_at(rate), seed),
                      search_.deadline, server_);
  }

  bool keeps(double rate) {
    const LoadRun one = run(rate);
    if (!one.kept) {
      high_ = high_ ? std::min(*high_, rate) : rate;
      return false;
    }
    low_ = rate;
    best_ = {rate,
             nearest_rank_quantile(one.latency_s, search_.deadline.share),
             0,
             false,
             rate * one.service_s,
             one.latency_s.size(),
             0};
    return true;
  }

  /// Steps from `guess` until there is a rate that is kept and one that is not, then bisects.
  void search(double guess, double lowest) {
    double step = first_step;
    for (double rate = guess; keeps(rate); rate *= step, step *= step) {
    }
    step = first_step;
    for (double rate = guess; !low_; step *= step) {
      rate = std::max(lowest, rate / step);
      if (!keeps(rate) && rate == lowest) return;
    }
    while (*high_ > search_.resolution * *low_) keeps(std::sqrt(*low_ * *high_));
  }

  KeptRate result() {
    if (best_.per_s) {
      const LoadRun again = run(*best_.per_s);
      best_.confirmed = again.kept;
      best_.confirmed_p99_s = nearest_rank_quantile(again.latency_s, search_.deadline.share);
    }
    best_.runs = runs_;
    return best_;
  }

  std::optional<double> low() const { return low_; }

 private:
  const RateSearch& search_;
  LoadServer& server_;
  std::optional<double> low_;
  std::optional<double> high_;
  KeptRate best_;
  int runs_ = 0;
};

}  // namespace

KeptRate highest_rate(const RateSearch& search, const std::vector<double>& service_s,
                      LoadServer& server) {
  const double lowest = lowest_utilisation / mean_of(service_s);
  SimulatedServer simulated(service_s);
  RateTrials guess(search, simulated);
  guess.search(0.9 / mean_of(service_s), lowest);
  // A server that misses the deadline even by itself is not worth minutes of trying.
  if (!guess.low()) return {};
  RateTrials trials(search, server);
  trials.search(*guess.low(), lowest);
  return trials.result();
}

}  // namespace ertbench
