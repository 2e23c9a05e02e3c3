#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/temporary_folder.h"

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

inline std::string read_text(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline void write_text(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

}  // namespace ertbench::testing
