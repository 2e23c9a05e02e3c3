#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace ertbench {

/// How a child process ended.
struct ProcessEnd {
  bool timed_out = false;
  int exit_code = -1;  ///< -1 where a signal ended it
  int signal = 0;

  bool ok() const { return !timed_out && exit_code == 0; }
};

/// A child process whose standard error goes to a file and whose standard output is discarded or
/// goes to another. It dies with its parent, and is killed with its whole process group when its
/// time is over.
class ChildProcess {
 public:
  /// Starts `arguments[0]`. Throws std::runtime_error where that is impossible.
  ChildProcess(const std::vector<std::string>& arguments, const std::filesystem::path& log,
               double time_limit_s, const std::filesystem::path& output = "/dev/null");
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();  ///< kills it where it still runs

  /// Whether it has ended, by itself or by its time limit; does not wait.
  std::optional<ProcessEnd> poll();
  ProcessEnd wait();

 private:
  int pid_ = -1;
  double deadline_ = 0;
  std::optional<ProcessEnd> end_;
};

}  // namespace ertbench
