#include "bench/benchmarks/benchmark_program.h"

#include <benchmark/benchmark.h>

namespace ertbench {

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
