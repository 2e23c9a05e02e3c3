#pragma once

#include <stdexcept>
#include <string>

namespace ertbench {

/// Input that cannot be used: a file, a JSON value, an HDF5 object. The message names the place and
/// the remedy ("experiments/x.json: /solvers/2/lambda: must be > 0 or \"auto\", got -1").
/// The program ends with exit code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace ertbench
