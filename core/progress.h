#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace ertbench {

/// Progress of one task on standard error: a bar with the time left on a terminal, a plain line
/// every ten seconds elsewhere.
class Progress {
 public:
  explicit Progress(std::string task);
  ~Progress();  ///< ends the bar's line

  /// `text` says what is going on, in place of the time left.
  void update(std::uint64_t done, std::uint64_t total, const std::string& text = "");

 private:
  using Clock = std::chrono::steady_clock;

  std::string task_;
  bool terminal_;
  Clock::time_point start_;
  Clock::time_point last_;
  std::uint64_t first_done_ = 0;  ///< where this process began, for the time left
  bool begun_ = false;
  bool line_open_ = false;
};

/// "4.2 s", "3 min 20 s", "2 h 5 min"
std::string duration_text(double seconds);

}  // namespace ertbench
