#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

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

/// Calls `work(begin, end)` for consecutive parts of [0, count), `chunk` items each (the last may
/// be shorter), on up to `threads` threads of which the caller's is one; returns when all are done.
/// Each thread takes the next part when it is free: what a part computes must not depend on which
/// thread runs it. Where parts throw, no further ones are begun, and the exception of the first of
/// them in the order of the items is rethrown: the one that a single thread would have met.
void parallel_for(std::size_t count, std::size_t chunk, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& work);

/// Divides [0, count) evenly, a part for each thread.
void parallel_for(std::size_t count, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& work);

/// How a child process ended.
struct ProcessEnd {
  bool timed_out = false;
  bool out_of_memory = false;  ///< killed, as its processes held more than they may
  int exit_code = -1;          ///< -1 where a signal ended it
  int signal = 0;
  int not_made = 0;  ///< the system's error where there could be no process

  bool ok() const { return !timed_out && !out_of_memory && exit_code == 0; }
  /// "exit code 3", "Segmentation fault", "out of memory", "out of time".
  std::string text() const;
};

/// Limits of a child process, which is ended when it exceeds one.
struct ProcessLimits {
  double time_s = 3600;
  std::uint64_t memory_bytes = 0;  ///< resident, of all its processes together; 0: any amount
};

/// The memory that this machine, or the control group that we run in, has.
std::uint64_t machine_memory_bytes();

/// Where a child process runs and what becomes of what it says.
struct ProcessSurroundings {
  /// Its standard error: the first megabyte and the last 64 kB of it.
  std::filesystem::path log = {};
  std::filesystem::path output = "/dev/null";  ///< its standard output; may be `log`
  std::filesystem::path folder = {};           ///< its working folder; empty: ours
};

/// A child process without standard input. It has a supervisor, a process between it and us, that
/// keeps its limits and its log and that ends whatever it started when it ends, when it has to end,
/// or when we end: also what left its process group or its session, or outlived its parent.
class ChildProcess {
 public:
  /// Starts `arguments[0]`, which is looked for in $PATH where it is a bare name. Throws
  /// std::system_error where no process can be made; one whose program cannot be started ends with
  /// exit code `not_started` and the reason in its log.
  ChildProcess(const std::vector<std::string>& arguments, const ProcessSurroundings& surroundings,
               const ProcessLimits& limits);
  static constexpr int not_started = 127;

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();  ///< kills it where it still runs

  /// Whether it has ended, by itself or by its limits; does not wait. Throws std::system_error
  /// where the supervisor could make no process.
  std::optional<ProcessEnd> poll();
  ProcessEnd wait();  ///< throws likewise

 private:
  int supervisor_ = -1;
  int report_ = -1;  ///< from which the supervisor's last word is read
  std::optional<ProcessEnd> end_;
};

/// Outcome of a function that ran in a copy of this process.
struct IsolatedOutcome {
  ProcessEnd end;
  bool finished = false;              ///< whether it returned and its process ended well
  std::vector<std::string> messages;  ///< all that it sent, in order
};

enum class StandardError { dropped, shared };

/// Runs a function in a copy of this process, supervised as a ChildProcess is, and waits for its
/// end: for what may take its process down with it, or never come back. What the function passes to
/// `send` comes back as messages, up to the last whole one. Its time is counted from the start and
/// anew from each message. An exception that leaves it ends the copy with exit code 1. This process
/// must have no other threads. Throws std::system_error where no process can be made.
IsolatedOutcome run_isolated(
    const std::function<void(const std::function<void(std::string_view message)>& send)>& function,
    const ProcessLimits& limits, StandardError standard_error = StandardError::dropped);

}  // namespace ertbench
