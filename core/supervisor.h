#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "core/process.h"

namespace ertbench {

/// The children of a process that have not been waited for, zombies among them.
std::vector<pid_t> children_of(pid_t process);

/// The resident memory of all descendants of a process together. Pages that several of them share
/// count for each.
std::uint64_t resident_bytes_below(pid_t process);

/// The descriptors that a supervised process gets; all are closed on exec.
struct Supervised {
  /// What the process does; it ends with exit code 0 where this returns and 1 where it throws.
  std::function<void()> run;
  int log = -1;  ///< a file for its standard error; -1: it keeps ours
  bool output_to_log = false;
  int output = -1;  ///< its standard output where that does not go to the log; -1: ours
  int input = -1;   ///< its standard input; -1: ours
  /// Our ends of its pipes, which the supervisor and the process close: the other side is to see
  /// where they end.
  std::vector<int> ours = {};
};

/// A supervisor, as we see it.
struct Supervisor {
  pid_t pid = -1;
  int report = -1;  ///< to be read from, see read_report
};

/// Starts a process and its supervisor, which
/// - ends it where it exceeds its limits, where it is told SIGTERM and where we die,
/// - is the subreaper of all that it starts, and ends that with it,
/// - copies what it says to the log, up to a bound,
/// - says in the end how it ended, and ends itself.
/// Throws std::system_error where no process can be made.
Supervisor start_supervised(const Supervised& task, const ProcessLimits& limits);

/// The last word of a supervisor that has ended; closes `report`.
ProcessEnd read_report(int report);

}  // namespace ertbench
