#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <vector>

#include "core/process.h"

namespace ertbench {

/// The children of a process, including zombies that have not been waited for.
std::vector<pid_t> children_of(pid_t process);

/// Resident memory of all descendants of a process. Shared pages count for each of them.
std::uint64_t resident_bytes_below(pid_t process);

/// Task and descriptors of a supervised process; all descriptors are closed on exec.
struct Supervised {
  /// Body of the process, which exits with 0 if it returns and with 1 if it throws.
  std::function<void()> run;
  int log = -1;  ///< file for its standard error; -1: inherited
  bool output_to_log = false;
  int output = -1;  ///< its standard output unless that goes to the log; -1: inherited
  int input = -1;   ///< its standard input; -1: inherited
  /// The caller's ends of its pipes. Supervisor and process close them, so that the other side sees
  /// the end of file.
  std::vector<int> ours = {};
};

/// A supervisor, seen from its parent.
struct Supervisor {
  pid_t pid = -1;
  int report = -1;  ///< descriptor for read_report
};

/// Starts a process and its supervisor, which
/// - ends the process if it exceeds its limits, on SIGTERM, and if the caller dies,
/// - is the subreaper of all descendants of the process, and ends them with it,
/// - copies its output to the log, up to a bound,
/// - reports how the process ended, and exits.
/// Throws std::system_error if no process can be made.
Supervisor start_supervised(const Supervised& task, const ProcessLimits& limits);

/// Reads the report of a supervisor that has exited; closes `report`.
ProcessEnd read_report(int report);

}  // namespace ertbench
