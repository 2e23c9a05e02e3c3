#include "bench/load/offered_load.h"

#include <cmath>

#include "core/quantile.h"
#include "core/random.h"

namespace ertbench {

const char* name_of(Arrivals arrivals) { return arrivals == Arrivals::fixed ? "fixed" : "poisson"; }

std::vector<double> arrival_times(Arrivals arrivals, double rate_per_s, std::size_t count,
                                  std::uint64_t seed) {
  std::vector<double> out;
  out.reserve(count);
  RandomStream random(seed, key_of("arrivals"), 0, Purpose::scene);
  double time_s = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double step =
        arrivals == Arrivals::fixed ? 1 : -std::log(1 - random.uniform());  // in mean distances
    time_s += step / rate_per_s;
    out.push_back(arrivals == Arrivals::fixed ? static_cast<double>(i) / rate_per_s : time_s);
  }
  return out;
}

std::size_t LoadDeadline::misses_allowed(std::size_t count) const {
  return count - 1 - nearest_rank(count, share);
}

LoadRun offer_load(const std::vector<double>& arrivals_s, const LoadDeadline& deadline,
                   LoadServer& server) {
  LoadRun run;
  run.latency_s.reserve(arrivals_s.size());
  const std::size_t allowed = deadline.misses_allowed(arrivals_s.size());
  const double begin_s = server.now_s();
  double worked_s = 0;
  for (std::size_t i = 0; i < arrivals_s.size(); ++i) {
    const double arrival_s = begin_s + arrivals_s[i];
    if (server.now_s() < arrival_s) server.wait_until(arrival_s);
    const double start_s = server.now_s();
    server.serve(i);
    const double end_s = server.now_s();
    worked_s += end_s - start_s;
    run.latency_s.push_back(end_s - arrival_s);
    run.missed += run.latency_s.back() > deadline.seconds;
    if (run.missed > allowed) {
      run.broken_off = i + 1 < arrivals_s.size();
      break;
    }
  }
  run.service_s = worked_s / static_cast<double>(run.latency_s.size());
  const double span_s = arrivals_s.back() - arrivals_s.front();
  const double mean_distance_s = span_s / static_cast<double>(arrivals_s.size() - 1);
  run.kept = run.missed <= allowed && run.service_s < mean_distance_s;
  return run;
}

}  // namespace ertbench
