#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "bench/table/table.h"

namespace ertbench {

struct TimingOptions {
  std::string filter;  ///< of names, as --benchmark_filter (a regular expression); empty: all
  std::filesystem::path out = "results/timing.json";
  int rounds = 3;  ///< of all programs in turn; the median counts
  /// Folder of the benchmark programs; by default `benchmarks` beside this program's folder.
  std::filesystem::path programs = benchmark_folder();

  static std::filesystem::path benchmark_folder();
};

/// Names of the Google Benchmark programs of a build.
const std::vector<std::string>& benchmark_programs();

/// Runs the benchmark programs one after the other, in rounds, with the limits of the machine
/// ("limit/...") always among them; prints a table to standard output and writes one file:
///
///     {"schema": 1, "provenance": {...}, "filter", "rounds", "note",
///      "programs": [{"name", "status": "ok" | "failed", "message", "context": {...}}],
///      "limits": [...], "benchmarks": [{"program", "name", "time_s", "rounds_s", ...}]}
///
/// The other keys of a benchmark are Google Benchmark's, from the median round. A program that
/// fails loses its results from that round on. Returns the number of failed programs. Throws
/// InputError if a program is missing, nothing matches the filter, or the file cannot be written.
int run_timing(const TimingOptions& options);

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

}  // namespace ertbench
