#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ertbench {

struct TimingOptions {
  std::string filter;  ///< of names, as --benchmark_filter (a regular expression); empty: all
  std::filesystem::path out = "results/timing.json";
  int rounds = 3;  ///< of all programs in turn; the median counts
  /// Where the benchmark programs stand; by default `benchmarks` beside this program's folder.
  std::filesystem::path programs = benchmark_folder();

  static std::filesystem::path benchmark_folder();
};

/// The Google Benchmark programs that a build makes.
const std::vector<std::string>& benchmark_programs();

/// Runs the benchmark programs one after the other, in rounds, with the limits of the machine
/// ("limit/...") always among them; prints a table to standard output and writes one file:
///
///     {"schema": 1, "provenance": {...}, "filter", "rounds", "note",
///      "programs": [{"name", "status": "ok" | "failed", "message", "context": {...}}],
///      "limits": [...], "benchmarks": [{"program", "name", "time_s", "rounds_s", ...}]}
///
/// The rest of a benchmark is Google Benchmark's, of the median round. A program that fails costs
/// its own results of that round and those after it. Returns how many failed.
/// Throws InputError where a program is missing, nothing matches the filter, or the file cannot be
/// written.
int run_timing(const TimingOptions& options);

}  // namespace ertbench
