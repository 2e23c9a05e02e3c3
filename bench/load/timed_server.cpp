#include "bench/load/timed_server.h"

#include <algorithm>
#include <ctime>

namespace ertbench {
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

}  // namespace ertbench
