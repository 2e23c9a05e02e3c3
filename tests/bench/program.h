#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/files.h"

namespace ertbench::testing {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code;
  std::string output;  ///< standard output and standard error
};

inline std::string quoted(const std::string& text) { return "'" + text + "'"; }

/// Runs the program as a user would, in `folder`, with a cache of its own there.
inline Outcome run_program(const fs::path& folder, const std::string& arguments,
                           const fs::path& program = ERTBENCH_PROGRAM) {
  const std::string command = "cd " + quoted(folder.string()) +
                              " && ERTBENCH_CACHE=" + quoted((folder / "cache").string()) + " " +
                              quoted(program.string()) + " " + arguments + " 2>&1 </dev/null";
  FILE* pipe = ::popen(command.c_str(), "r");
  Outcome outcome{-1, ""};
  char buffer[4096];
  while (const std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe)) {
    outcome.output.append(buffer, n);
  }
  const int status = ::pclose(pipe);
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

using ertbench::TemporaryFolder;

/// Copies the program and the libraries beside it, but not the learned solvers, into `folder`/bench
/// and links the other libraries' folders beside that. Returns the copy.
inline fs::path copy_program(const fs::path& folder) {
  const fs::path built = fs::path(ERTBENCH_PROGRAM).parent_path();
  fs::create_directories(folder / "bench");
  for (const auto& entry : fs::directory_iterator(built)) {
    const std::string name = entry.path().filename();
    const bool library = name.starts_with("libertbench_") && name.ends_with(".so");
    if (name != "ertbench" && (!library || name == "libertbench_models.so")) continue;
    fs::copy_file(entry.path(), folder / "bench" / name);
  }
  for (const char* room : {"core", "forward", "solvers"}) {
    fs::create_directory_symlink(built.parent_path() / room, folder / room);
  }
  return folder / "bench/ertbench";
}

inline std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

/// As long as it lives, programs find a gnuplot in `folder`/bin that fails.
class FailingGnuplot {
 public:
  explicit FailingGnuplot(const fs::path& folder) : path_(std::getenv("PATH")) {
    fs::create_directory(folder / "bin");
    write_text(folder / "bin/gnuplot", "#!/bin/sh\necho it is on fire >&2; exit 1\n");
    fs::permissions(folder / "bin/gnuplot", fs::perms::owner_all);
    ::setenv("PATH", ((folder / "bin").string() + ":" + path_).c_str(), 1);
  }
  FailingGnuplot(const FailingGnuplot&) = delete;
  FailingGnuplot& operator=(const FailingGnuplot&) = delete;
  ~FailingGnuplot() { ::setenv("PATH", path_.c_str(), 1); }

 private:
  std::string path_;
};

}  // namespace ertbench::testing
