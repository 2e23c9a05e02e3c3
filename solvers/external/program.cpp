#include "solvers/external/program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cerrno>
#include <cstdint>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t most_quoted = 600;    ///< characters of its standard error in a message
constexpr std::size_t most_kept = 1 << 13;  ///< bytes of it in memory
constexpr int quoted_lines = 4;

struct PipeEnds {
  int read = -1;
  int write = -1;
};

PipeEnds open_pipe() {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "no pipe");
  }
  // Room for a batch, so that neither side waits in the middle of one. If the system refuses, the
  // batch is sent in smaller pieces.
  ::fcntl(ends[0], F_SETPIPE_SZ, 1 << 20);
  return {ends[0], ends[1]};
}

void set_nonblocking(int descriptor) {
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
}

void close_end(int& descriptor) {
  if (descriptor >= 0) ::close(descriptor);
  descriptor = -1;
}

/// The last lines of a text that are not empty.
std::string last_lines(const std::string& text) {
  std::vector<std::string> lines;
  for (const std::string& one : split(text, "\n")) {
    if (one.find_first_not_of(" \t\r") != std::string::npos) lines.push_back(one);
  }
  std::string out;
  const std::size_t count = std::min<std::size_t>(lines.size(), quoted_lines);
  for (std::size_t i = lines.size() - count; i < lines.size(); ++i) {
    out += out.empty() ? "" : " | ";
    out += one_line(lines[i], most_quoted / quoted_lines);
  }
  return out;
}

/// A destructor cannot throw: the first bad end is kept for require_programs_ended_well.
std::mutex bad_end_mutex;
std::optional<std::pair<std::string, std::string>> bad_end;  ///< status and message

// The protocol's numbers are little-endian, and so are this machine's.
static_assert(std::endian::native == std::endian::little);

template <typename T>
std::string_view bytes_of(const T* values, std::size_t count) {
  return {reinterpret_cast<const char*>(values), count * sizeof(T)};
}

template <typename T>
std::span<char> room_of(T* values, std::size_t count) {
  return {reinterpret_cast<char*>(values), count * sizeof(T)};
}

template <typename Rows>
bool row_behind_row(const Rows& rows) {
  return rows.rows() == 1 || rows.outerStride() == rows.cols();
}

}  // namespace

/// Buffers to send or to fill, with the position reached.
template <typename Part>
struct Program::Transfer {
  std::span<const Part> parts;
  std::size_t part = 0;
  std::size_t moved = 0;  ///< of that part

  bool done() {
    while (part < parts.size() && moved == parts[part].size()) {
      ++part;
      moved = 0;
    }
    return part == parts.size();
  }
};

Program::Program(std::string name, const std::function<void()>& run, std::uint64_t memory_bytes)
    : name_(std::move(name)), memory_bytes_(memory_bytes) {
  ::signal(SIGPIPE,
           SIG_IGN);  // a program that does not read any more is an error of ours to report
  PipeEnds input = open_pipe();
  PipeEnds output = open_pipe();
  PipeEnds errors = open_pipe();
  input_ = input.write;
  output_ = output.read;
  errors_ = errors.read;
  Supervised task;
  task.run = [&] {
    ::dup2(errors.write, STDERR_FILENO);
    ::close(errors.write);
    run();
  };
  task.input = input.read;
  task.output = output.write;
  task.ours = {input_, output_, errors_};
  try {
    supervisor_ = start_supervised(task, {std::numeric_limits<double>::infinity(), memory_bytes_});
  } catch (...) {
    for (int* one : {&input.read, &output.write, &errors.write, &input_, &output_, &errors_}) {
      close_end(*one);
    }
    throw;
  }
  for (int* one : {&input.read, &output.write, &errors.write}) close_end(*one);
  for (const int one : {input_, output_, errors_}) set_nonblocking(one);
}

void require_programs_ended_well() {
  const std::lock_guard lock(bad_end_mutex);
  if (!bad_end) return;
  const auto [status, message] = *std::exchange(bad_end, std::nullopt);
  throw FailedTrial(status, message);
}

Program::~Program() {
  constexpr double patience_s = 10;
  try {
    const bool was_running = !end_;
    end(patience_s);
    pass_on_errors();
    if (was_running && !failed_ && (ended_by_us_ || !end_->ok())) {
      const std::lock_guard lock(bad_end_mutex);
      const std::string how =
          ended_by_us_ ? "did not end within " + duration_text(patience_s) + " when its input did"
                       : "ended badly (" + end_->text() + ") after its last answer";
      const std::string said = last_lines(said_);
      if (!bad_end) {
        bad_end = {end_->signal != 0 && !ended_by_us_ ? "crashed" : "failed",
                   name_ + ": " + how + "; it must end with 0 once its input ends" +
                       (said.empty() ? "" : "; it said: " + said)};
      }
    }
  } catch (...) {  // nothing more can be done about it
  }
  close_end(output_);
  close_end(errors_);
}

void Program::end(double patience_s) {
  if (end_) return;
  close_end(input_);
  const SteadyClock::time_point start = SteadyClock::now();
  while (::waitpid(supervisor_.pid, nullptr, WNOHANG) == 0) {
    if (seconds_since(start) > patience_s) {
      ended_by_us_ = true;
      ::kill(supervisor_.pid, SIGTERM);
      while (::waitpid(supervisor_.pid, nullptr, 0) < 0 && errno == EINTR) {
      }
      break;
    }
    pass_on_errors();
    ::poll(nullptr, 0, 1);
  }
  end_ = read_report(supervisor_.report);
}

void Program::send(std::string_view bytes, double limit_s) {
  const std::array<std::string_view, 1> parts = {bytes};
  exchange(parts, {}, limit_s);
}

std::string Program::line(double limit_s, std::size_t most) {
  const SteadyClock::time_point start = SteadyClock::now();
  while (true) {
    const std::size_t end_of_line = rest_.find('\n');
    if (end_of_line != std::string::npos) {
      std::string out = rest_.substr(0, end_of_line);
      rest_.erase(0, end_of_line + 1);
      return out;
    }
    if (rest_.size() > most) {
      fail("failed", "its first line has no end after " + std::to_string(most) +
                         " bytes; it begins «" + printable(rest_, 80) + "»");
    }
    wait(true, false, start, limit_s, "was not ready");
    char bytes[1 << 12];
    const ssize_t count = ::read(output_, bytes, sizeof bytes);
    if (count > 0) rest_.append(bytes, static_cast<std::size_t>(count));
    if (count == 0) fail_ended();
  }
}

void Program::exchange(std::span<const std::string_view> out, std::span<const std::span<char>> in,
                       double limit_s) {
  Outgoing outgoing{out};
  Incoming incoming{in};
  if (!in.empty()) require_nothing_unasked();
  const SteadyClock::time_point start = SteadyClock::now();
  while (true) {
    const bool writing = !outgoing.done() && write_some(outgoing);
    if (!writing && incoming.done()) break;
    wait(!incoming.done(), writing, start, limit_s, "had not answered");
    if (!incoming.done()) read_some(incoming);
  }
  // Checked after the answer, too: text among the images shifts their end.
  if (!in.empty()) require_nothing_unasked();
}

void Program::require_nothing_unasked() {
  pollfd unasked{output_, POLLIN, 0};
  const bool more = ::poll(&unasked, 1, 0) > 0 && (unasked.revents & POLLIN) != 0;
  if (rest_.empty() && !more) return;
  char bytes[80];
  const ssize_t count = more ? ::read(output_, bytes, sizeof bytes) : 0;
  if (count > 0) rest_.append(bytes, static_cast<std::size_t>(count));
  if (rest_.empty()) return;  // it has closed its output
  fail("failed", "wrote more to its standard output than it was asked for («" +
                     printable(rest_, 80) + "»); text for people belongs on standard error");
}

bool Program::write_some(Outgoing& out) {
  while (!out.done()) {
    std::array<iovec, 8> pieces;
    int count = 0;
    for (std::size_t part = out.part; part < out.parts.size() && count < 8; ++part, ++count) {
      const std::size_t sent = part == out.part ? out.moved : 0;
      pieces[static_cast<std::size_t>(count)] = {const_cast<char*>(out.parts[part].data()) + sent,
                                                 out.parts[part].size() - sent};
    }
    const ssize_t written = ::writev(input_, pieces.data(), count);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0 && errno == EAGAIN) return true;
    if (written < 0) fail_ended();
    for (auto left = static_cast<std::size_t>(written); left > 0;) {
      const std::size_t here = std::min(left, out.parts[out.part].size() - out.moved);
      out.moved += here;
      left -= here;
      out.done();
    }
  }
  return false;
}

void Program::read_some(Incoming& in) {
  while (!in.done()) {
    const std::span<char> part = in.parts[in.part].subspan(in.moved);
    const ssize_t count = ::read(output_, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    if (count <= 0) fail_ended();
    in.moved += static_cast<std::size_t>(count);
  }
}

void Program::wait(bool reading, bool writing, SteadyClock::time_point start, double limit_s,
                   const char* what) {
  const auto events = static_cast<short>(POLLIN);
  std::array<pollfd, 3> ends = {pollfd{reading ? output_ : -1, events, 0},
                                pollfd{errors_, events, 0},
                                pollfd{writing ? input_ : -1, POLLOUT, 0}};
  while (true) {
    const double left_s = limit_s - seconds_since(start);
    if (left_s <= 0) {
      fail("timed out", std::string(what) + " after " + duration_text(limit_s));
    }
    const int pause_ms = static_cast<int>(std::min(left_s, 1.0) * 1000) + 1;
    if (::poll(ends.data(), ends.size(), pause_ms) <= 0) continue;
    if (ends[1].revents != 0) pass_on_errors();
    if (errors_ < 0) ends[1].fd = -1;
    if (ends[0].revents != 0 || ends[2].revents != 0) return;
  }
}

void Program::pass_on_errors() {
  char bytes[1 << 12];
  while (errors_ >= 0) {
    const ssize_t count = ::read(errors_, bytes, sizeof bytes);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return;
    if (count == 0) {
      close_end(errors_);
      return;
    }
    said_.append(bytes, static_cast<std::size_t>(count));
    if (said_.size() > 2 * most_kept) said_.erase(0, said_.size() - most_kept);
    if (::write(STDERR_FILENO, bytes, static_cast<std::size_t>(count)) < 0) continue;
  }
}

void Program::fail_ended() {
  constexpr double patience_s = 1;  // it may have closed the pipe and live on
  end(patience_s);
  if (end_->out_of_memory) {
    fail("out of memory",
         "needed more than " + std::to_string(memory_bytes_ >> 20U) + " MB (\"memory_limit_mb\")");
  }
  if (ended_by_us_) fail("failed", "closed its standard input or output");
  if (end_->signal != 0) fail("crashed", end_->text());
  if (end_->exit_code == ChildProcess::not_started) fail("failed", "cannot be started");
  fail("failed", "ended (" + end_->text() + ") before it had answered");
}

void Program::fail(const std::string& status, const std::string& what) {
  failed_ = true;
  try {
    if (status == "timed out") end(0);
    pass_on_errors();
  } catch (...) {  // what it said last is not worth another failure
  }
  const std::string said = last_lines(said_);
  throw FailedTrial(status, name_ + ": " + what + (said.empty() ? "" : "; it said: " + said));
}

void FrameExchange::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) {
  const std::lock_guard lock(one_at_a_time_);
  const auto frames = static_cast<std::uint64_t>(changes.rows());
  if (frames == 0) return;
  Frames dense_changes;
  Images dense_images;
  const double* sent = changes.data();
  double* received = images.data();
  if (!row_behind_row(changes)) {
    dense_changes = changes;
    sent = dense_changes.data();
  }
  const bool copied = !row_behind_row(images);
  if (copied) {
    dense_images.resize(images.rows(), images.cols());
    received = dense_images.data();
  }
  std::array<std::uint8_t, 64> few;
  std::vector<std::uint8_t> many(frames > few.size() ? frames : 0);
  std::uint8_t* const statuses = many.empty() ? few.data() : many.data();
  const std::array<std::string_view, 2> out = {
      bytes_of(&frames, 1), bytes_of(sent, static_cast<std::size_t>(changes.size()))};
  const std::array<std::span<char>, 2> in = {
      room_of(received, static_cast<std::size_t>(images.size())), room_of(statuses, frames)};
  program_.exchange(out, in, frame_limit_s_ * static_cast<double>(frames));
  if (copied) images = dense_images;
  for (std::uint64_t f = 0; f < frames; ++f) {
    if (statuses[f] > static_cast<std::uint8_t>(FrameStatus::suspect)) {
      throw FailedTrial("failed", "the program gave a frame the status " +
                                      std::to_string(statuses[f]) +
                                      "; it must be 0 (ok), 1 (not converged), 2 (undefined) or 3 "
                                      "(suspect): are there as many bytes as the protocol has?");
    }
    reports[f].status = static_cast<FrameStatus>(statuses[f]);
  }
}

}  // namespace ertbench
