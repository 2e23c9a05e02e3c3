#pragma once

#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace ertbench
