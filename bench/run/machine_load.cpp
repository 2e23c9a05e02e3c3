#include "bench/run/machine_load.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

namespace ertbench {
namespace {

double steady_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The first line of /proc/stat: user, nice, system, idle, iowait, irq, softirq and steal, in ticks
/// (proc(5)). Time that another guest of the same host stole disturbs as much.
double machine_busy_s() {
  std::ifstream in("/proc/stat");
  std::string word;
  in >> word;
  double busy = 0;
  for (int column = 0; column < 8; ++column) {
    double ticks = 0;
    in >> ticks;
    if (column != 3 && column != 4) busy += ticks;
  }
  return in ? busy / static_cast<double>(::sysconf(_SC_CLK_TCK)) : 0;
}

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

double process_s() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
}

}  // namespace

int usable_cores() {
  cpu_set_t set;
  // Fails where the machine has more processors than a set of this size.
  if (sched_getaffinity(0, sizeof set, &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

MachineLoad::MachineLoad() : busy_s_(machine_busy_s()), own_s_(process_s()), start_s_(steady_s()) {}

double MachineLoad::others_cores() const {
  constexpr double least_s = 0.1;  // ten ticks: less time does not resolve a tenth of a core
  const double elapsed = steady_s() - start_s_;
  if (elapsed < least_s) return 0;
  const double others = machine_busy_s() - busy_s_ - (process_s() - own_s_);
  return std::max(0.0, others / elapsed);
}

}  // namespace ertbench
