#include "core/process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace ertbench {
namespace {

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

ProcessEnd end_of(int status) {
  ProcessEnd end;
  if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  return end;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments,
                           const ProcessSurroundings& surroundings, double time_limit_s)
    : deadline_(now() + time_limit_s) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  constexpr int writing = O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC;
  const std::string folder = surroundings.folder.string();
  const int err = ::open(surroundings.log.c_str(), writing, 0644);
  const int out = ::open(surroundings.output.c_str(), writing, 0644);
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t parent = ::getpid();
  pid_ = err >= 0 && out >= 0 && null >= 0 ? ::fork() : -1;
  if (pid_ == 0) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) _exit(127);  // it died before we asked
    ::dup2(null, STDIN_FILENO);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(err, STDERR_FILENO);
    if (folder.empty() || ::chdir(folder.c_str()) == 0) ::execvp(argv[0], argv.data());
    const char* why = std::strerror(errno);
    if (::write(STDERR_FILENO, why, std::strlen(why)) < 0) _exit(126);
    _exit(not_started);
  }
  const int error = errno;
  for (const int descriptor : {err, out, null}) {
    if (descriptor >= 0) ::close(descriptor);
  }
  if (pid_ < 0) {
    throw std::runtime_error("cannot start " + arguments[0] + ": " + std::strerror(error));
  }
  ::setpgid(pid_, pid_);  // also here: whoever comes first
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(other.pid_), deadline_(other.deadline_), end_(other.end_) {
  other.pid_ = -1;
}

ChildProcess::~ChildProcess() {
  if (pid_ > 0 && !end_) {
    ::kill(-pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
}

std::optional<ProcessEnd> ChildProcess::poll() {
  if (end_) return end_;
  int status = 0;
  bool timed_out = false;
  pid_t ended = ::waitpid(pid_, &status, WNOHANG);
  if (ended == 0 && now() > deadline_) {
    timed_out = true;
    ::kill(-pid_, SIGKILL);
    ended = ::waitpid(pid_, &status, 0);
  }
  if (ended == 0) return std::nullopt;
  end_ = end_of(status);
  end_->timed_out = timed_out;
  return end_;
}

ProcessEnd ChildProcess::wait() {
  while (!poll()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return *end_;
}

ProcessEnd run_in_child(const std::function<void()>& function, unsigned time_limit_s) {
  const pid_t child = ::fork();
  if (child < 0) return {.exit_code = 0};
  if (child == 0) {
    ::signal(SIGABRT, SIG_DFL);
    ::signal(SIGALRM, SIG_DFL);
    ::alarm(time_limit_s);
    ::dup2(::open("/dev/null", O_WRONLY), STDERR_FILENO);
    try {
      function();
    } catch (...) {
    }
    ::_exit(0);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return end_of(status);
}

}  // namespace ertbench
