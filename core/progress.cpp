#include "core/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "core/text.h"

namespace ertbench {
namespace {

/// Of the terminal; a bar longer than its line would stay on the screen.
std::size_t columns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

}  // namespace

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
    : task_(printable(task)), terminal_(::isatty(STDERR_FILENO) == 1), start_(Clock::now()) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', stderr);
}

void Progress::update(std::uint64_t done, std::uint64_t total, const std::string& text) {
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
  std::string state = std::to_string(total ? 100 * done / total : 100) + "%";
  if (!text.empty()) {
    state += ": " + printable(text);
  } else if (done > first_done_ && done < total) {
    state +=
        ", " + duration_text(elapsed * double(total - done) / double(done - first_done_)) + " left";
  }
  if (terminal_) {
    std::string bar(25, ' ');
    std::fill_n(bar.begin(), total ? 25 * done / total : 25, '#');
    const std::string start = task_ + " [" + bar + "] ";
    const std::size_t room = columns() - std::min(columns() - 2, start.size() + 2);
    std::fprintf(stderr, "\r\033[K%s%s", start.c_str(), one_line(state, room).c_str());
    line_open_ = true;
  } else {
    std::fprintf(stderr, "%s %s\n", task_.c_str(), state.c_str());
  }
  std::fflush(stderr);
}

}  // namespace ertbench
