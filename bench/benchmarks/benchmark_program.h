#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <functional>
#include <string>

/// What this machine can do at most on one thread, against which the benchmarks hold what they
/// measure. Each limit is the best of many tries by the thread's processor time, measured when it
/// is first asked for and then kept for the life of the process.
namespace ertbench {

/// FLOP/s of Eigen's product of two large square matrices.
double gemm_double_rate();
double gemm_float_rate();

/// Least time in which this many bytes are read once, from whichever cache or memory holds an array
/// of that size that is read over and over, s.
double streaming_time(std::int64_t bytes);

/// Least processor time of one call, s, of as many as fit into `budget_s`.
double least_time(const std::function<void()>& call, double budget_s = 0.3);

/// Adds to a benchmark whose iteration cannot take less than `least_s`:
/// - the counter `limit_us`, that time in microseconds;
/// - the counter `of_limit`, that time over the measured one: the fraction of the limit's rate (the
///   "/s" that Google Benchmark prints behind it means nothing);
/// - the label `limit`, which names what sets the limit: "stream", "gemm_double", ...
void compare_with_limit(benchmark::State& state, double least_s, const std::string& limit);

/// Shows a rate as the benchmark "limit/<name>": its time is that of 1e9 operations, its counter
/// FLOP/s is the rate.
void register_rate(const std::string& name, double (*rate)());
/// Shows the reading of so many bytes as "limit/stream/<bytes>", with the counter bytes_per_second.
void register_streaming(std::int64_t bytes);

/// The main function of a benchmark program: runs what is registered, as Google Benchmark's options
/// say, and notes in the context of its output how ertbench itself was built ("debug" there is how
/// Debian built Google Benchmark). Returns the exit code.
int run_benchmarks(int argc, char** argv);

}  // namespace ertbench
