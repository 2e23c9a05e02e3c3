#include "core/process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "core/errors.h"
#include "core/files.h"
#include "core/seconds.h"
#include "core/supervisor.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Of the terminal; a bar longer than its line would stay on the screen.
std::size_t columns() {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

/// Closes a descriptor.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  Descriptor(Descriptor&&) = delete;
  ~Descriptor() { close(); }
  int get() const { return descriptor_; }
  void close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }

 private:
  int descriptor_;
};

/// To be written from its beginning.
int open_to_write(const std::filesystem::path& file) {
  const int descriptor =
      ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (descriptor < 0) {
    throw InputError(file.string() + ": cannot be written: " + std::strerror(errno) +
                     "; check that its folder exists, may be written and has space");
  }
  return descriptor;
}

/// Stands in the place of a message's length behind the last one. A process that ends before its
/// function returns, with whatever exit code, does not send it.
constexpr std::uint64_t finished_mark = std::numeric_limits<std::uint64_t>::max();

/// Each message goes through the pipe behind its length.
void send_bytes(int pipe, std::uint64_t length, std::string_view message) {
  std::string bytes(reinterpret_cast<const char*>(&length), sizeof length);
  bytes += message;
  if (!write_all(pipe, bytes)) throw std::runtime_error("nobody takes the message");
}

/// Moves the whole messages from the beginning of what came through a pipe to the outcome; whether
/// there were any.
bool take_messages(std::string& bytes, IsolatedOutcome& outcome) {
  const std::size_t before = bytes.size();
  std::uint64_t length = 0;
  while (bytes.size() >= sizeof length) {
    std::memcpy(&length, bytes.data(), sizeof length);
    if (length == finished_mark) {
      outcome.finished = true;
      bytes.clear();
      break;
    }
    if (bytes.size() - sizeof length < length) break;
    outcome.messages.push_back(bytes.substr(sizeof length, length));
    bytes.erase(0, sizeof length + length);
  }
  return bytes.size() < before;
}

/// Whether there is more to come.
bool read_some(int pipe, std::string& bytes) {
  char some[1 << 16];
  const ssize_t count = ::read(pipe, some, sizeof some);
  if (count > 0) bytes.append(some, static_cast<std::size_t>(count));
  return count > 0 || (count < 0 && errno == EINTR);
}

/// What the supervisor could not make, we could not make either.
void require_made(const ProcessEnd& end) {
  if (end.not_made == 0) return;
  throw std::system_error(end.not_made, std::generic_category(), "no process can be made");
}

ProcessEnd wait_for(const Supervisor& supervisor) {
  while (::waitpid(supervisor.pid, nullptr, 0) < 0 && errno == EINTR) {
  }
  return read_report(supervisor.report);
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

std::string ProcessEnd::text() const {
  if (timed_out) return "out of time";
  if (out_of_memory) return "out of memory";
  if (signal != 0) return strsignal(signal);
  return "exit code " + std::to_string(exit_code);
}

std::uint64_t machine_memory_bytes() {
  auto bytes = static_cast<std::uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
               static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  for (const char* limit :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::uint64_t of_group = 0;
    if (std::ifstream(limit) >> of_group) bytes = std::min(bytes, of_group);
  }
  return bytes;
}

ChildProcess::ChildProcess(const std::vector<std::string>& arguments,
                           const ProcessSurroundings& surroundings, const ProcessLimits& limits) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const std::string folder = surroundings.folder.string();
  const bool to_log = surroundings.output == surroundings.log;
  const Descriptor log(open_to_write(surroundings.log));
  const Descriptor output(open_to_write(to_log ? "/dev/null" : surroundings.output));
  const Descriptor input(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  const auto execute = [&] {
    if (folder.empty() || ::chdir(folder.c_str()) == 0) ::execvp(argv[0], argv.data());
    const char* why = std::strerror(errno);
    if (::write(STDERR_FILENO, why, std::strlen(why)) < 0) ::_exit(126);
    ::_exit(not_started);
  };
  const Supervisor supervisor =
      start_supervised({execute, log.get(), to_log, output.get(), input.get()}, limits);
  supervisor_ = supervisor.pid;
  report_ = supervisor.report;
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : supervisor_(other.supervisor_), report_(other.report_), end_(other.end_) {
  other.supervisor_ = -1;
}

ChildProcess::~ChildProcess() {
  if (supervisor_ > 0 && !end_) {
    ::kill(supervisor_, SIGTERM);
    wait_for({supervisor_, report_});
  }
}

std::optional<ProcessEnd> ChildProcess::poll() {
  if (!end_ && ::waitpid(supervisor_, nullptr, WNOHANG) != 0) end_ = read_report(report_);
  if (end_) require_made(*end_);
  return end_;
}

ProcessEnd ChildProcess::wait() {
  if (!end_) end_ = wait_for({supervisor_, report_});
  require_made(*end_);
  return *end_;
}

IsolatedOutcome run_isolated(
    const std::function<void(const std::function<void(std::string_view message)>& send)>& function,
    const ProcessLimits& limits, StandardError standard_error) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "no pipe");
  }
  const Descriptor read_end(ends[0]);
  Descriptor write_end(ends[1]);
  const Descriptor null(::open("/dev/null", O_RDWR | O_CLOEXEC));
  const bool dropped = standard_error == StandardError::dropped;
  const auto run = [&] {
    ::close(ends[0]);
    if (dropped) ::dup2(null.get(), STDERR_FILENO);
    function([&](std::string_view message) { send_bytes(ends[1], message.size(), message); });
    send_bytes(ends[1], finished_mark, "");
  };
  const Supervised task{run, -1, false, dropped ? null.get() : -1, null.get()};
  // Its time begins anew with each message, of which the supervisor knows nothing.
  const Supervisor supervisor =
      start_supervised(task, {std::numeric_limits<double>::infinity(), limits.memory_bytes});
  write_end.close();

  IsolatedOutcome outcome;
  std::string bytes;
  SteadyClock::time_point last = SteadyClock::now();
  bool more = true;
  bool timed_out = false;
  while (more && !timed_out) {
    pollfd one{read_end.get(), POLLIN, 0};
    if (::poll(&one, 1, 50) > 0) more = read_some(read_end.get(), bytes);
    if (take_messages(bytes, outcome)) last = SteadyClock::now();
    timed_out = seconds_since(last) > limits.time_s;
  }
  if (timed_out) ::kill(supervisor.pid, SIGTERM);
  outcome.end = wait_for(supervisor);
  require_made(outcome.end);
  outcome.end.timed_out = timed_out;
  outcome.finished = outcome.finished && outcome.end.ok();
  return outcome;
}

void parallel_for(std::size_t count, std::size_t chunk, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& work) {
  std::mutex mutex;
  std::size_t next = 0;
  std::size_t failed_at = count;
  std::exception_ptr failure;
  const auto take = [&] {
    const std::lock_guard lock(mutex);
    return failure ? count : std::exchange(next, std::min(count, next + chunk));
  };
  const auto run = [&] {
    for (std::size_t begin = take(); begin < count; begin = take()) {
      try {
        work(begin, std::min(count, begin + chunk));
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (begin >= failed_at) continue;
        failed_at = begin;
        failure = std::current_exception();
      }
    }
  };
  {
    const std::size_t parts = (count + chunk - 1) / chunk;
    std::vector<std::jthread> helpers;
    for (std::size_t t = 1; t < std::min(parts, static_cast<std::size_t>(std::max(1, threads)));
         ++t) {
      helpers.emplace_back(run);
    }
    run();
  }
  if (failure) std::rethrow_exception(failure);
}

void parallel_for(std::size_t count, int threads,
                  const std::function<void(std::size_t begin, std::size_t end)>& work) {
  const auto parts = static_cast<std::size_t>(std::max(1, threads));
  parallel_for(count, std::max<std::size_t>(1, (count + parts - 1) / parts), threads, work);
}

}  // namespace ertbench
