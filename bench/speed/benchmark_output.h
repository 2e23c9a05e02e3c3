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

/// Parses the file of a Google Benchmark program's --benchmark_out. Version 1.7.1 writes bare NaN
/// and infinity, which JSON does not allow; they become null. Throws std::runtime_error with the
/// reason if the text is no such output, or incomplete.
nlohmann::json parse_benchmark_output(std::string_view text);

/// One benchmark of one program, in every round that it was run.
struct TimedBenchmark {
  std::string program;
  std::vector<nlohmann::json> rounds;  ///< Google Benchmark's objects; not empty

  std::string name() const { return rounds.front().at("name"); }
  bool is_limit() const { return name().starts_with("limit/"); }
};

/// Adds the benchmarks of one round of a program to those of earlier rounds.
void add_round(const std::string& program, const nlohmann::json& output,
               std::vector<TimedBenchmark>& benchmarks);

/// Seconds per iteration: wall time for "/real_time", the benchmark's own for "/manual_time",
/// otherwise processor time, which excludes others on the same core. NaN if the benchmark failed.
double seconds_of(const nlohmann::json& benchmark);

/// The entry of timing.json: the median round (the faster of the two in the middle), with
/// "program", "time_s" and all rounds' times, "rounds_s".
nlohmann::json median_of(const TimedBenchmark& benchmark);

/// A table of name, time, rate and fraction of the limit. `medians` as from median_of.
TableSection timing_table(const std::string& program, const std::vector<nlohmann::json>& medians);

/// A Google Benchmark program, run as a child process. If it fails, the functions throw
/// std::runtime_error with how it ended and its last output.
class BenchmarkProcess {
 public:
  /// `folder` is for temporary files and must outlive this.
  BenchmarkProcess(std::filesystem::path program, std::filesystem::path folder);

  std::string name() const { return program_.filename(); }

  /// The names of its benchmarks that match `filter`, as --benchmark_filter; empty: all.
  std::vector<std::string> list(const std::string& filter) const;

  /// Runs them and returns the parsed output (parse_benchmark_output). `finished` is called a few
  /// times a second with the number of benchmarks done.
  nlohmann::json run(const std::string& filter,
                     const std::function<void(std::uint64_t)>& finished) const;

 private:
  std::filesystem::path program_;
  std::filesystem::path folder_;
};

}  // namespace ertbench
