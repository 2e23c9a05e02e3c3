#include "bench/progress.h"

#include <unistd.h>

#include <cstdio>

namespace ertbench {

std::string duration_text(double seconds) {
  char text[64];
  if (seconds < 60) {
    std::snprintf(text, sizeof text, "%.1f s", seconds);
  } else if (seconds < 3600) {
    std::snprintf(text, sizeof text, "%d min %d s", static_cast<int>(seconds) / 60,
                  static_cast<int>(seconds) % 60);
  } else {
    std::snprintf(text, sizeof text, "%d h %d min", static_cast<int>(seconds) / 3600,
                  static_cast<int>(seconds) / 60 % 60);
  }
  return text;
}

Progress::Progress(std::string task)
    : task_(std::move(task)), terminal_(::isatty(STDERR_FILENO) == 1), start_(Clock::now()) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', stderr);
}

void Progress::update(std::uint64_t done, std::uint64_t total) {
  const Clock::time_point time = Clock::now();
  const bool first = !begun_;
  if (first) {
    begun_ = true;
    first_done_ = done;
    start_ = time;
  }
  const double pause = terminal_ ? 0.1 : 10;
  if (done < total && std::chrono::duration<double>(time - last_).count() < pause) return;
  last_ = time;
  const double elapsed = std::chrono::duration<double>(time - start_).count();
  std::string left;
  if (done > first_done_ && done < total) {
    left =
        ", " + duration_text(elapsed * double(total - done) / double(done - first_done_)) + " left";
  }
  const int percent = total ? static_cast<int>(100 * done / total) : 100;
  if (terminal_) {
    const std::string bar(static_cast<std::size_t>(percent) / 4, '#');
    std::fprintf(stderr, "\r\033[K%s [%-25s] %d%%%s", task_.c_str(), bar.c_str(), percent,
                 left.c_str());
    line_open_ = true;
  } else {
    std::fprintf(stderr, "%s: %d%%%s\n", task_.c_str(), percent, left.c_str());
  }
  std::fflush(stderr);
}

}  // namespace ertbench
