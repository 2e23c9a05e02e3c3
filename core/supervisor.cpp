#include "core/supervisor.h"

#include <dirent.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <system_error>

#include "core/files.h"
#include "core/seconds.h"

namespace ertbench {
namespace {

/// Contents of a small file of /proc; empty if the process has gone.
std::string text_of(const std::string& file) {
  std::FILE* const in = std::fopen(file.c_str(), "re");
  if (!in) return "";
  char text[1024];
  const std::size_t size = std::fread(text, 1, sizeof text, in);
  std::fclose(in);
  return {text, size};
}

/// Parent of a process; 0 if the process has gone.
pid_t parent_of(pid_t process) {
  // "12 (any (name)) S 11 ...": the fields begin after the last bracket.
  const std::string stat = text_of("/proc/" + std::to_string(process) + "/stat");
  const std::size_t bracket = stat.rfind(')');
  if (bracket == std::string::npos || bracket + 4 >= stat.size()) return 0;
  return static_cast<pid_t>(std::strtol(stat.c_str() + bracket + 4, nullptr, 10));
}

std::multimap<pid_t, pid_t> children_by_parent() {
  std::multimap<pid_t, pid_t> children;
  DIR* const folder = ::opendir("/proc");
  if (!folder) return children;
  while (const dirent* entry = ::readdir(folder)) {
    const auto process = static_cast<pid_t>(std::strtol(entry->d_name, nullptr, 10));
    if (process > 0) children.emplace(parent_of(process), process);
  }
  ::closedir(folder);
  return children;
}

std::uint64_t resident_bytes(pid_t process) {
  const std::string statm = text_of("/proc/" + std::to_string(process) + "/statm");
  const std::size_t space = statm.find(' ');
  if (space == std::string::npos) return 0;
  return std::strtoull(statm.c_str() + space, nullptr, 10) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t resident_below(pid_t process, const std::multimap<pid_t, pid_t>& children) {
  std::uint64_t sum = 0;
  const auto [first, last] = children.equal_range(process);
  for (auto one = first; one != last; ++one) {
    sum += resident_bytes(one->second) + resident_below(one->second, children);
  }
  return sum;
}

volatile sig_atomic_t told_to_stop = 0;

void set_handler(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  ::sigaction(signal, &action, nullptr);
}

/// Copies the output of a pipe to a file: the beginning at once, then the last part of the rest. A
/// file that cannot be written is no reason to stop.
class BoundedLog {
 public:
  BoundedLog(int pipe, int file) : pipe_(pipe), file_(file) {}

  int pipe() const { return pipe_; }

  /// Reads what is available; closes the pipe once it has no writer any more.
  void drain() {
    char bytes[1 << 16];
    while (pipe_ >= 0) {
      const ssize_t count = ::read(pipe_, bytes, sizeof bytes);
      if (count > 0) {
        add({bytes, static_cast<std::size_t>(count)});
      } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
        ::close(pipe_);
        pipe_ = -1;
      } else if (errno == EAGAIN) {
        return;
      }
    }
  }

  void finish() {
    drain();
    if (left_out_ > 0) {
      write_all(file_, "\n... " + std::to_string(left_out_) + " bytes left out ...\n");
    }
    write_all(file_, end_);
  }

 private:
  static constexpr std::size_t most_at_first = 1 << 20;
  static constexpr std::size_t most_at_last = 1 << 16;

  void add(std::string_view bytes) {
    const std::size_t first = std::min(bytes.size(), most_at_first - written_);
    write_all(file_, bytes.substr(0, first));
    written_ += first;
    end_ += bytes.substr(first);
    if (end_.size() > 2 * most_at_last) {
      left_out_ += end_.size() - most_at_last;
      end_.erase(0, end_.size() - most_at_last);
    }
  }

  int pipe_;
  int file_;
  std::size_t written_ = 0;
  std::string end_;
  std::size_t left_out_ = 0;
};

/// The supervised process itself, from its first instruction.
[[noreturn]] void become_supervised(const Supervised& task, int log_pipe, pid_t supervisor) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != supervisor) ::_exit(1);  // it died before we asked
  for (const int signal : {SIGTERM, SIGCHLD, SIGINT, SIGPIPE, SIGABRT}) {
    set_handler(signal, SIG_DFL);
  }
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  if (task.input >= 0) ::dup2(task.input, STDIN_FILENO);
  if (task.output >= 0) ::dup2(task.output, STDOUT_FILENO);
  if (log_pipe >= 0) ::dup2(log_pipe, STDERR_FILENO);
  if (log_pipe >= 0 && task.output_to_log) ::dup2(log_pipe, STDOUT_FILENO);
  try {
    task.run();
  } catch (...) {
    ::_exit(1);
  }
  ::_exit(0);
}

/// Body of the supervisor process.
class Supervision {
 public:
  Supervision(const Supervised& task, const ProcessLimits& limits, int report)
      : task_(task), limits_(limits), report_(report) {}

  [[noreturn]] void run(pid_t parent) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    ::prctl(PR_SET_CHILD_SUBREAPER, 1);
    prepare_signals();
    if (::getppid() != parent) told_to_stop = 1;
    for (const int descriptor : task_.ours) ::close(descriptor);
    int pipe[2] = {-1, -1};
    if (task_.log >= 0 && ::pipe2(pipe, O_CLOEXEC) != 0) say_not_made();
    const pid_t supervisor = ::getpid();
    child_ = ::fork();
    if (child_ == 0) {
      ::close(report_);
      become_supervised(task_, pipe[1], supervisor);
    }
    if (child_ < 0) say_not_made();
    ::setpgid(child_, child_);  // both sides do it, as either may run first
    if (pipe[1] >= 0) ::close(pipe[1]);
    if (!task_.ours.empty()) {
      for (const int descriptor : {task_.input, task_.output}) ::close(descriptor);
    }
    if (pipe[0] >= 0) ::fcntl(pipe[0], F_SETFL, O_NONBLOCK);
    BoundedLog log(pipe[0], task_.log);
    watch(log);
    end_all();
    log.finish();
    report();
  }

 private:
  [[noreturn]] void report() {
    write_all(report_, {reinterpret_cast<const char*>(&end_), sizeof end_});
    ::_exit(0);
  }

  [[noreturn]] void say_not_made() {
    end_.not_made = errno;
    report();
  }

  /// Signals come only while we wait in ppoll.
  void prepare_signals() {
    set_handler(SIGTERM, [](int) { told_to_stop = 1; });
    set_handler(SIGCHLD, [](int) {});
    set_handler(SIGINT, SIG_IGN);
    set_handler(SIGPIPE, SIG_IGN);
    sigset_t blocked;
    ::sigemptyset(&blocked);
    ::sigaddset(&blocked, SIGTERM);
    ::sigaddset(&blocked, SIGCHLD);
    ::sigprocmask(SIG_BLOCK, &blocked, &unblocked_);
    ::sigdelset(&unblocked_, SIGTERM);
    ::sigdelset(&unblocked_, SIGCHLD);
  }

  void watch(BoundedLog& log) {
    const SteadyClock::time_point start = SteadyClock::now();
    double next_look_s = 0;
    while (!reap() && told_to_stop == 0) {
      const double elapsed_s = seconds_since(start);
      if (elapsed_s > limits_.time_s) {
        end_.timed_out = true;
        return;
      }
      if (limits_.memory_bytes > 0 && elapsed_s >= next_look_s) {
        if (resident_bytes_below(::getpid()) > limits_.memory_bytes) {
          end_.out_of_memory = true;
          return;
        }
        // Reading /proc may take at most a hundredth of the time, however many processes there are.
        const double look_s = seconds_since(start) - elapsed_s;
        next_look_s = elapsed_s + std::clamp(100 * look_s, 0.05, 1.0);
      }
      pollfd one{log.pipe(), POLLIN, 0};
      const timespec pause{0, 20'000'000};
      ::ppoll(&one, 1, &pause, &unblocked_);
      log.drain();
    }
  }

  /// Reaps all children that have ended; true if the process itself is one of them.
  bool reap() {
    int status = 0;
    for (pid_t ended = 0; (ended = ::waitpid(-1, &status, WNOHANG)) > 0;) {
      if (ended != child_) continue;
      if (WIFEXITED(status)) end_.exit_code = WEXITSTATUS(status);
      if (WIFSIGNALED(status)) end_.signal = WTERMSIG(status);
      ended_ = true;
    }
    return ended_;
  }

  /// Ends all descendants. Orphans are children of this process, their subreaper.
  void end_all() {
    constexpr double most_s = 10;  // for a process that the kernel does not let go
    const SteadyClock::time_point start = SteadyClock::now();
    if (!ended_) ::kill(-child_, SIGKILL);
    while (seconds_since(start) < most_s) {
      reap();
      const std::vector<pid_t> left = children_of(::getpid());
      if (left.empty()) return;
      for (const pid_t one : left) ::kill(one, SIGKILL);
      const timespec pause{0, 1'000'000};
      ::ppoll(nullptr, 0, &pause, &unblocked_);
    }
  }

  const Supervised& task_;
  const ProcessLimits& limits_;
  int report_;
  sigset_t unblocked_{};
  pid_t child_ = -1;
  bool ended_ = false;
  ProcessEnd end_;
};

}  // namespace

std::vector<pid_t> children_of(pid_t process) {
  std::vector<pid_t> out;
  const std::multimap<pid_t, pid_t> all = children_by_parent();
  const auto [first, last] = all.equal_range(process);
  for (auto one = first; one != last; ++one) out.push_back(one->second);
  return out;
}

std::uint64_t resident_bytes_below(pid_t process) {
  return resident_below(process, children_by_parent());
}

Supervisor start_supervised(const Supervised& task, const ProcessLimits& limits) {
  int report[2];
  if (::pipe2(report, O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "no pipe");
  }
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::close(report[0]);
    Supervision(task, limits, report[1]).run(parent);
  }
  const int error = errno;
  ::close(report[1]);
  if (pid < 0) {
    ::close(report[0]);
    throw std::system_error(error, std::generic_category(), "no process can be made");
  }
  return {pid, report[0]};
}

ProcessEnd read_report(int report) {
  ProcessEnd end;
  const ssize_t count = ::read(report, &end, sizeof end);
  ::close(report);
  if (count == static_cast<ssize_t>(sizeof end)) return end;
  ProcessEnd killed;  // the supervisor itself was
  killed.signal = SIGKILL;
  return killed;
}

}  // namespace ertbench
