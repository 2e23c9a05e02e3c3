#include "bench/live/line_output.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <nlohmann/json.hpp>

#include "bench/live/stop.h"
#include "core/json_text.h"

namespace ertbench {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds patience_at_the_end{1000};

}  // namespace

bool LineOutput::wait_for_reader() {
  if (!until_ && stop_.wait_to_write(STDOUT_FILENO)) return true;
  if (!until_) until_ = std::chrono::steady_clock::now() + patience_at_the_end;
  pollfd output{STDOUT_FILENO, POLLOUT, 0};
  int ready = 0;
  do {
    const auto left =
        std::chrono::duration_cast<milliseconds>(*until_ - std::chrono::steady_clock::now());
    ready = ::poll(&output, 1, static_cast<int>(std::max(left, milliseconds(0)).count()));
  } while (ready < 0 && errno == EINTR);
  return ready > 0;
}

void LineOutput::line(const nlohmann::json& value) {
  const std::string text = json_text(value) + "\n";
  for (std::size_t at = 0; open_ && at < text.size();) {
    const std::size_t most = std::min<std::size_t>(PIPE_BUF, text.size() - at);
    if (!wait_for_reader()) {
      open_ = false;
      return;
    }
    const ssize_t n = ::write(STDOUT_FILENO, text.data() + at, most);
    if (n > 0) {
      at += static_cast<std::size_t>(n);
    } else if (n == 0 || errno != EINTR) {
      open_ = false;
      error_ = n < 0 && errno != EPIPE && errno != ECONNRESET ? errno : 0;
    }
  }
}

}  // namespace ertbench
