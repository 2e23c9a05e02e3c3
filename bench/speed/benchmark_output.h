#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "bench/table/table.h"

namespace ertbench {

/// What a Google Benchmark program wrote with --benchmark_out. Version 1.7.1 writes NaN and
/// infinity bare, which JSON does not know: they become null. Throws std::runtime_error with what
/// is wrong where the text is no such output, or not whole.
nlohmann::json parse_benchmark_output(std::string_view text);

/// One benchmark of one program, in every round that it was run.
struct TimedBenchmark {
  std::string program;
  std::vector<nlohmann::json> rounds;  ///< as Google Benchmark writes a benchmark; not empty

  std::string name() const { return rounds.front().at("name"); }
  bool is_limit() const { return name().starts_with("limit/"); }
};

/// Adds the benchmarks of one round of a program to those of earlier rounds.
void add_round(const std::string& program, const nlohmann::json& output,
               std::vector<TimedBenchmark>& benchmarks);

/// Seconds of an iteration: wall time of a benchmark that asked for it ("/real_time"), its own time
/// of one that measures itself ("/manual_time"), else processor time, which others on the same core
/// do not add to. NaN where the benchmark failed.
double seconds_of(const nlohmann::json& benchmark);

/// The median round (the faster of the two in the middle), with "program", "time_s" and all rounds'
/// times, "rounds_s": what stands in timing.json.
nlohmann::json median_of(const TimedBenchmark& benchmark);

/// For people: name, time, rate, fraction of which limit. `medians` as median_of gives them.
TableSection timing_table(const std::string& program, const std::vector<nlohmann::json>& medians);

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
