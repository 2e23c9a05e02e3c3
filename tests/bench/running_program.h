#pragma once

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/program.h"

namespace ertbench::testing {

/// The program as a child whose standard input and output are pipes of ours; its standard error
/// goes to a file.
class RunningProgram {
 public:
  RunningProgram(const fs::path& folder, std::vector<std::string> arguments)
      : errors_(folder / "errors.log") {
    int in[2];
    int out[2];
    if (::pipe2(in, O_CLOEXEC) != 0 || ::pipe2(out, O_CLOEXEC) != 0) std::abort();
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(in[0], STDIN_FILENO);
      ::dup2(out[1], STDOUT_FILENO);
      ::dup2(::open(errors_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
      ::setenv("ERTBENCH_CACHE", (folder / "cache").c_str(), 1);
      if (::chdir(folder.c_str()) != 0) ::_exit(126);
      arguments.insert(arguments.begin(), ERTBENCH_PROGRAM);
      std::vector<char*> argv;
      for (std::string& argument : arguments) argv.push_back(argument.data());
      argv.push_back(nullptr);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    to_ = in[1];
    from_ = out[0];
  }
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;
  ~RunningProgram() {
    close_input();
    close_output();
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }

  void write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::write(to_, bytes.data(), bytes.size());
      if (n <= 0) return;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void close_input() {
    if (to_ >= 0) ::close(to_);
    to_ = -1;
  }
  void close_output() {
    if (from_ >= 0) ::close(from_);
    from_ = -1;
  }
  void signal(int number) const { ::kill(pid_, number); }

  /// The next line of its standard output; nothing at the end, or after so long.
  std::optional<std::string> line(double patience_s = 60) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(patience_s);
    while (buffer_.find('\n') == std::string::npos) {
      pollfd end{from_, POLLIN, 0};
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
          until - std::chrono::steady_clock::now());
      if (left.count() <= 0 || ::poll(&end, 1, static_cast<int>(left.count())) <= 0) return {};
      char bytes[65536];
      const ssize_t n = ::read(from_, bytes, sizeof bytes);
      if (n <= 0) return {};
      buffer_.append(bytes, static_cast<std::size_t>(n));
    }
    std::string line = buffer_.substr(0, buffer_.find('\n'));
    buffer_.erase(0, line.size() + 1);
    return line;
  }

  /// The next line that is this event, with the lines before passed over; null where none comes.
  nlohmann::json event(const std::string& name) {
    while (const std::optional<std::string> text = line()) {
      nlohmann::json value = nlohmann::json::parse(*text);
      if (value.value("event", "") == name) return value;
    }
    return nullptr;
  }

  /// All lines from here to the end.
  std::vector<nlohmann::json> lines() {
    std::vector<nlohmann::json> out;
    while (const std::optional<std::string> text = line()) {
      out.push_back(nlohmann::json::parse(*text));
    }
    return out;
  }

  /// Waits for its end; 128 and the signal where that ended it.
  int exit_code() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  std::string errors() const { return read_text(errors_); }

 private:
  fs::path errors_;
  pid_t pid_ = -1;
  int to_ = -1;
  int from_ = -1;
  std::string buffer_;
};

}  // namespace ertbench::testing
