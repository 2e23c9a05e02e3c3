#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace ertbench {

/// Input that cannot be used: a file, a JSON value, an HDF5 object. The message names the place and
/// the remedy ("experiments/x.json: /solvers/2/lambda: must be > 0 or \"auto\", got -1").
/// The program exits with code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Ends a trial for a reason that is neither a defect of ours nor bad input, such as a crash of the
/// program that a solver runs in. The row gets the status and the message.
class FailedTrial : public InputError {
 public:
  FailedTrial(std::string status, const std::string& message)
      : InputError(message), status_(std::move(status)) {}
  /// "crashed", "timed out", "out of memory" or "failed".
  const std::string& status() const { return status_; }

 private:
  std::string status_;
};

}  // namespace ertbench
