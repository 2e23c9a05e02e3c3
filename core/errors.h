#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace ertbench {

/// Input that cannot be used: a file, a JSON value, an HDF5 object. The message names the place and
/// the remedy ("experiments/x.json: /solvers/2/lambda: must be > 0 or \"auto\", got -1").
/// The program ends with exit code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What ends a trial without a defect of ours and without bad input: a program that a solver runs
/// in has crashed, say. The row gets the status and the message.
class FailedTrial : public InputError {
 public:
  FailedTrial(std::string status, const std::string& message)
      : InputError(message), status_(std::move(status)) {}
  /// A word or two: "crashed", "timed out", "out of memory", "failed".
  const std::string& status() const { return status_; }

 private:
  std::string status_;
};

}  // namespace ertbench
