#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace ertbench {

/// A Google Benchmark program, run as a child process. Its functions throw std::runtime_error with
/// how the program ended and the last of what it said, where it did not end well.
class BenchmarkProcess {
 public:
  /// `folder` is for files in between and outlives this.
  BenchmarkProcess(std::filesystem::path program, std::filesystem::path folder);

  std::string name() const { return program_.filename(); }

  /// The names of its benchmarks that match `filter`, as --benchmark_filter; empty: all.
  std::vector<std::string> list(const std::string& filter) const;

  /// Runs them and returns what parse_benchmark_output makes of what it writes. `finished` is
  /// called a few times a second with the number of benchmarks done.
  nlohmann::json run(const std::string& filter,
                     const std::function<void(std::uint64_t)>& finished) const;

 private:
  std::filesystem::path program_;
  std::filesystem::path folder_;
};

}  // namespace ertbench
