#include "bench/live/line_output.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <nlohmann/json.hpp>

#include "bench/live/stop.h"
#include "core/json_text.h"

namespace ertbench {

void LineOutput::line(const nlohmann::json& value) {
  const std::string text = json_text(value) + "\n";
  for (std::size_t at = 0; open_ && at < text.size();) {
    const std::size_t most = std::min<std::size_t>(PIPE_BUF, text.size() - at);
    const ssize_t n =
        stop_.wait_to_write(STDOUT_FILENO) ? ::write(STDOUT_FILENO, text.data() + at, most) : -1;
    if (n > 0) at += static_cast<std::size_t>(n);
    open_ = n > 0 || (n < 0 && errno == EINTR && !stop_.stopped());
  }
}

}  // namespace ertbench
