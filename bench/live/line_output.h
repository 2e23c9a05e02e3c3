#pragma once

#include <nlohmann/json_fwd.hpp>

namespace ertbench {

class Stop;

/// Lines of JSON on standard output.
class LineOutput {
 public:
  explicit LineOutput(const Stop& stop) : stop_(stop) {}

  /// Waits for a reader that is slow, but not beyond the end of the stream.
  void line(const nlohmann::json& value);
  /// Whether all lines got out; nobody reads them any more, else.
  bool open() const { return open_; }

 private:
  const Stop& stop_;
  bool open_ = true;
};

}  // namespace ertbench
