#include "bench/speed/offered_load.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <numeric>

#include "core/random.h"
#include "core/statistics.h"

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

namespace {

constexpr std::size_t warm_up_frames = 20;

double thread_cpu_s() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

TimedServer::TimedServer(const Solver& solver, const Frames& voltages,
                         const Eigen::RowVectorXd& reference, int pixels)
    : solver_(solver),
      voltages_(voltages),
      reference_(reference),
      change_(1, voltages.cols()),
      image_(1, pixels),
      start_(SteadyClock::now()),
      start_cpu_s_(thread_cpu_s()) {}

double TimedServer::now_s() { return seconds_since(start_); }

void TimedServer::wait_until(double time_s) {
  while (now_s() < time_s) {
  }
}

void TimedServer::serve(std::size_t frame) {
  FrameReport report;
  change_ = voltages_.row(static_cast<Eigen::Index>(frame) % voltages_.rows()) - reference_;
  solver_.reconstruct(change_, image_, {&report, 1});
}

std::vector<double> TimedServer::service_s(std::size_t frames) {
  std::vector<double> out;
  for (std::size_t i = 0; i < warm_up_frames; ++i) serve(i);
  for (std::size_t i = 0; i < frames; ++i) {
    const double start = now_s();
    serve(i);
    out.push_back(now_s() - start);
  }
  return out;
}

double TimedServer::lost_share() const {
  return std::max(0.0, 1 - (thread_cpu_s() - start_cpu_s_) / seconds_since(start_));
}

namespace {

/// If a rate this far below the capacity does not keep the deadline, none does.
constexpr double lowest_utilisation = 0.01;
constexpr double first_step = 1.15;

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Tries rates on one server and stores the highest that kept the deadline.
class RateTrials {
 public:
  RateTrials(const RateSearch& search, LoadServer& server) : search_(search), server_(server) {}

  std::size_t frames_at(double rate) const {
    const double lasting = search_.least_deadlines * search_.deadline.seconds * rate;
    return std::max(search_.least_frames, static_cast<std::size_t>(std::ceil(lasting)));
  }

  LoadRun run(double rate) {
    // Every run draws its own arrivals, so that the best rate does not fit one particular draw.
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

  /// Steps from `guess` until one rate was kept and one was not, then bisects.
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
  // A server that misses the deadline without any queue needs no search.
  if (!guess.low()) return {};
  RateTrials trials(search, server);
  trials.search(*guess.low(), lowest);
  return trials.result();
}

}  // namespace ertbench
