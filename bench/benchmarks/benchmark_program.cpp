#include "bench/benchmarks/benchmark_program.h"

#include <Eigen/Core>
#include <algorithm>
#include <ctime>
#include <limits>
#include <map>

namespace ertbench {
namespace {

constexpr double shortest_s = 1e-3;  ///< of one timed block: the clock itself takes 0.3 us

double processor_time() {
  timespec time{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double time_of(const std::function<void()>& call, int calls) {
  const double start = processor_time();
  for (int i = 0; i < calls; ++i) call();
  return processor_time() - start;
}

template <typename Scalar>
double gemm_rate() {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  double best = 0;
  for (const Eigen::Index size : {512, 1024}) {
    const Matrix a = Matrix::Constant(size, size, Scalar(0.5));
    const Matrix b = Matrix::Constant(size, size, Scalar(0.25));
    Matrix product(size, size);
    const double seconds = least_time([&] {
      product.noalias() = a * b;
      benchmark::DoNotOptimize(product.data());
    });
    best = std::max(best, 2 * static_cast<double>(size * size * size) / seconds);
  }
  return best;
}

/// Enough independent sums to make reading, not adding, the bottleneck.
float sum(const Eigen::ArrayXf& numbers) {
  constexpr Eigen::Index lanes = 128;
  Eigen::Array<float, lanes, 1> sums = Eigen::Array<float, lanes, 1>::Zero();
  const Eigen::Index whole = numbers.size() / lanes * lanes;
  for (Eigen::Index i = 0; i < whole; i += lanes) sums += numbers.segment<lanes>(i);
  return sums.sum() + numbers.tail(numbers.size() - whole).sum();
}

}  // namespace

double least_time(const std::function<void()>& call, double budget_s) {
  int calls = 1;
  while (time_of(call, calls) < shortest_s) calls *= 2;
  double best = std::numeric_limits<double>::infinity();
  for (double spent = 0; spent < budget_s;) {
    const double seconds = time_of(call, calls);
    best = std::min(best, seconds / calls);
    spent += seconds;
  }
  return best;
}

double gemm_double_rate() {
  static const double rate = gemm_rate<double>();
  return rate;
}

double gemm_float_rate() {
  static const double rate = gemm_rate<float>();
  return rate;
}

double streaming_time(std::int64_t bytes) {
  static std::map<std::int64_t, double> known;
  const auto [entry, unknown] = known.try_emplace(bytes);
  if (unknown) {
    const Eigen::ArrayXf numbers =
        Eigen::ArrayXf::Ones(bytes / static_cast<std::int64_t>(sizeof(float)));
    entry->second = least_time([&] { benchmark::DoNotOptimize(sum(numbers)); });
  }
  return entry->second;
}

void compare_with_limit(benchmark::State& state, double least_s, const std::string& limit) {
  using benchmark::Counter;
  state.counters["limit_us"] = 1e6 * least_s;
  state.counters["of_limit"] = Counter(least_s, Counter::kIsIterationInvariantRate);
  state.SetLabel(limit);
}

void register_rate(const std::string& name, double (*rate)()) {
  constexpr double operations = 1e9;
  benchmark::RegisterBenchmark(("limit/" + name).c_str(),
                               [rate](benchmark::State& state) {
                                 for (auto _ : state) state.SetIterationTime(operations / rate());
                                 state.counters["FLOP/s"] = benchmark::Counter(
                                     operations, benchmark::Counter::kIsIterationInvariantRate);
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMillisecond);
}

void register_streaming(std::int64_t bytes) {
  benchmark::RegisterBenchmark(("limit/stream/" + std::to_string(bytes)).c_str(),
                               [bytes](benchmark::State& state) {
                                 for (auto _ : state) {
                                   state.SetIterationTime(streaming_time(bytes));
                                 }
                                 state.SetBytesProcessed(bytes);
                               })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMicrosecond);
}

int run_benchmarks(int argc, char** argv) {
#ifdef NDEBUG
  benchmark::AddCustomContext("ertbench_build_type", "release");
#else
  benchmark::AddCustomContext("ertbench_build_type", "debug");
#endif
  benchmark::AddCustomContext("google_benchmark", ERTBENCH_GOOGLE_BENCHMARK);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}

}  // namespace ertbench
