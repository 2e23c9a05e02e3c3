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

/// Throws FailedTrial if a program of this process has ended badly after its last answer, when its
/// Program was destroyed: with another exit code than 0, by a signal, or not at all within ten
/// seconds of the end of its input. What such a program has answered is no result.
void require_programs_ended_well();

/// A supervised child process with pipes to its standard input and output. Its failures throw
/// FailedTrial with the cause and the last lines of its standard error, which is forwarded to ours.
/// Used by one thread at a time.
class Program {
 public:
  /// `run` is the body of the child: it replaces the process by a program, or returns. `name` is
  /// for messages. Throws std::system_error if no process can be made.
  Program(std::string name, const std::function<void()>& run, std::uint64_t memory_bytes);
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  /// Closes the child's standard input, waits a moment, and ends it with all its descendants.
  ~Program();

  /// Sends bytes and reads none.
  void send(std::string_view bytes, double limit_s);
  /// Reads the next line, without its end, of at most `most` bytes.
  std::string line(double limit_s, std::size_t most);
  /// Sends the parts of `out` in their order and fills those of `in`, overlapped in any way. Bytes
  /// that the child sent before it was asked are a failure.
  void exchange(std::span<const std::string_view> out, std::span<const std::span<char>> in,
                double limit_s);

 private:
  template <typename Part>
  struct Transfer;
  using Outgoing = Transfer<std::string_view>;
  using Incoming = Transfer<std::span<char>>;

  /// Waits until the child can be read from, if `reading`, or written to, if `writing`; forwards
  /// its standard error meanwhile.
  void wait(bool reading, bool writing, SteadyClock::time_point start, double limit_s,
            const char* what);
  /// Returns true if there is more to write.
  bool write_some(Outgoing& out);
  void read_some(Incoming& in);
  void require_nothing_unasked();
  void pass_on_errors();
  /// Throws the reason why the child has closed a pipe.
  [[noreturn]] void fail_ended();
  [[noreturn]] void fail(const std::string& status, const std::string& what);
  void end(double patience_s);

  std::string name_;
  std::uint64_t memory_bytes_;
  int input_ = -1;    ///< written here
  int output_ = -1;   ///< read here
  int errors_ = -1;   ///< read here
  std::string said_;  ///< end of its standard error
  std::string rest_;  ///< bytes read after the last line
  Supervisor supervisor_;
  std::optional<ProcessEnd> end_;
  bool ended_by_us_ = false;
  bool failed_ = false;  ///< a failure was thrown, which says more than its end
};

/// Step 3 of the protocol: sends n and n frames, receives n images and n bytes of status. Allocates
/// nothing if frames and images are contiguous. Thread-safe; calls are serialised.
class FrameExchange {
 public:
  /// `program` must outlive this.
  FrameExchange(Program& program, double frame_limit_s)
      : program_(program), frame_limit_s_(frame_limit_s) {}

  /// Throws FailedTrial like Program, and for a byte that is no FrameStatus.
  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport> reports);

 private:
  Program& program_;
  double frame_limit_s_;
  std::mutex one_at_a_time_;
};

}  // namespace ertbench
