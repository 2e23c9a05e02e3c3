#pragma once

#include <filesystem>
#include <functional>
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

/// Where a child process runs and what becomes of what it says.
struct ProcessSurroundings {
  std::filesystem::path log = {};              ///< its standard error
  std::filesystem::path output = "/dev/null";  ///< its standard output; may be `log`
  std::filesystem::path folder = {};           ///< its working folder; empty: ours
};

/// A child process without standard input. It dies with its parent, and is killed with its whole
/// process group when its time is over.
class ChildProcess {
 public:
  /// Starts `arguments[0]`, which is looked for in $PATH where it is a bare name. Throws
  /// std::runtime_error where no process can be made; one whose program cannot be started ends with
  /// exit code `not_started` and the reason in its log.
  ChildProcess(const std::vector<std::string>& arguments, const ProcessSurroundings& surroundings,
               double time_limit_s);
  static constexpr int not_started = 127;

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

/// Runs a function in a copy of this process, whose standard error is discarded, and waits for its
/// end: for what may take its process down with it. Exceptions end the copy in order, with exit
/// code 0. Where no process can be made, nothing runs and all counts as well.
ProcessEnd run_in_child(const std::function<void()>& function, unsigned time_limit_s);

}  // namespace ertbench
