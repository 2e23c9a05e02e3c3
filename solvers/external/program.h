#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/process.h"
#include "core/seconds.h"
#include "core/supervisor.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// A supervised child process that is talked to over its standard input and output. Whatever goes
/// wrong with it throws FailedTrial with what happened and the last lines that it wrote to standard
/// error, which otherwise goes to ours. One thread at a time.
class Program {
 public:
  /// `run` is the child's life: it replaces the process by a program, or returns in the end.
  /// `name` is for messages. Throws std::system_error where no process can be made.
  Program(std::string name, const std::function<void()>& run, std::uint64_t memory_bytes);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  /// Closes its standard input, gives it a moment to end and ends it with all that it started.
  ~Program();

  /// Sends bytes and takes none.
  void send(std::string_view bytes, double limit_s);
  /// The next line, without its end, of at most `most` bytes.
  std::string line(double limit_s, std::size_t most);
  /// Sends the parts one after the other and receives as many bytes as the others hold, however
  /// the two overlap. Bytes that it had sent before nobody asked are a failure.
  void exchange(std::span<const std::string_view> out, std::span<const std::span<char>> in,
                double limit_s);

 private:
  struct Outgoing;
  struct Incoming;

  /// Waits until it can be written to (where `writing`) or read from; what it says on standard
  /// error is passed on meanwhile.
  void wait(bool writing, SteadyClock::time_point start, double limit_s, const char* what);
  /// Whether there is more to write.
  bool write_some(Outgoing& out);
  void read_some(Incoming& in);
  void require_nothing_unasked();
  void pass_on_errors();
  /// It has closed a pipe: how it ended.
  [[noreturn]] void fail_ended();
  [[noreturn]] void fail(const std::string& status, const std::string& what);
  void end(double patience_s);

  std::string name_;
  std::uint64_t memory_bytes_;
  int input_ = -1;    ///< we write
  int output_ = -1;   ///< we read
  int errors_ = -1;   ///< we read
  std::string said_;  ///< the end of what it wrote to standard error
  std::string rest_;  ///< read behind the last line
  Supervisor supervisor_;
  std::optional<ProcessEnd> end_;
  bool ended_by_us_ = false;
};

/// Step 3 of the protocol: n, n frames out; n images and n bytes of status in. Nothing is allocated
/// for frames and images that lie row behind row. Any number of threads, one after the other.
class FrameExchange {
 public:
  /// `program` must outlive this.
  FrameExchange(Program& program, double frame_limit_s)
      : program_(program), frame_limit_s_(frame_limit_s) {}

  /// Throws FailedTrial as Program does, and where a byte of status is no FrameStatus.
  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport> reports);

 private:
  Program& program_;
  double frame_limit_s_;
  std::mutex one_at_a_time_;
};

}  // namespace ertbench
