#pragma once

#include <benchmark/benchmark.h>

#include <cstdint>
#include <functional>
#include <string>

/// Limits of this machine on one thread, with which benchmarks compare their measurements. Each is
/// the best of many tries by the thread's processor time, measured on first use and then kept.
namespace ertbench {

/// FLOP/s in Eigen's product of two large square matrices.
double gemm_double_rate();
double gemm_float_rate();

/// Shortest time, s, to read this many bytes repeatedly from whichever cache or memory holds them.
double streaming_time(std::int64_t bytes);

/// Shortest processor time of one call, s, among as many calls as fit into `budget_s`.
double least_time(const std::function<void()>& call, double budget_s = 0.3);

/// Adds to a benchmark whose iteration cannot take less than `least_s`:
/// - the counter `limit_us`, that time in microseconds;
/// - the counter `of_limit`, that time over the measured one (ignore the "/s" that Google Benchmark
///   prints behind it);
/// - the label `limit`, which names the limiting resource: "stream", "gemm_double", ...
void compare_with_limit(benchmark::State& state, double least_s, const std::string& limit);

/// Registers a rate as the benchmark "limit/<name>": its time is that of 1e9 operations, its
/// counter FLOP/s is the rate.
void register_rate(const std::string& name, double (*rate)());
/// Registers reading this many bytes as "limit/stream/<bytes>", with the counter bytes_per_second.
void register_streaming(std::int64_t bytes);

/// The main function of a benchmark program: runs what is registered, by Google Benchmark's
/// options, and adds ertbench's own build type to the output's context, where "debug" is that of
/// Debian's Google Benchmark. Returns the exit code.
int run_benchmarks(int argc, char** argv);

}  // namespace ertbench
