#pragma once

#include <chrono>
#include <nlohmann/json_fwd.hpp>
#include <optional>

namespace ertbench {

class Stop;

/// Lines of JSON on standard output.
class LineOutput {
 public:
  explicit LineOutput(const Stop& stop) : stop_(stop) {}

  /// Waits for a reader that is slow; once the stream was told to end, for a second in all, so that
  /// it may still have the last lines.
  void line(const nlohmann::json& value);
  /// Whether all lines got out; nobody reads them any more, else, or `error` says why not.
  bool open() const { return open_; }
  /// Of the system, where lines could not be written though somebody might read them; 0 else.
  int error() const { return error_; }

 private:
  bool wait_for_reader();

  const Stop& stop_;
  bool open_ = true;
  int error_ = 0;
  std::optional<std::chrono::steady_clock::time_point> until_;  ///< once it was told to end
};

}  // namespace ertbench
