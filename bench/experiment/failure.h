#pragma once

#include <string>

namespace ertbench {

/// Why a solver, or a job of it, has no result.
struct Failure {
  std::string status;  ///< "failed", "timed out", "crashed", "out of memory", "not run"
  std::string message;

  std::string text() const { return message.empty() ? status : status + ": " + message; }
};

}  // namespace ertbench
