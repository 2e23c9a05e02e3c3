// Timing of dataset files: written as `ertbench generate` writes them, and read.
//
//   build/release/benchmarks/dataset_benchmark
//
// The files stand in the folder for temporary files ($TMPDIR, else /tmp), whose disk is part of
// what is measured; what is read is still in the system's memory. `generate_rows` of
// forward_benchmark makes the same scenes without a file. One thread; items are scenes. "Debug" in
// the header is how Debian's Google Benchmark was built; ertbench itself is a release.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>

#include "bench/benchmarks/benchmark_program.h"
#include "core/files.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t block = 256;  ///< scenes read at a time, as in a trial

DatasetSpec training(std::int64_t count) {
  DatasetSpec spec;
  spec.name = "train";
  spec.count = static_cast<std::uint64_t>(count);
  spec.noise = {50, SnrBasis::absolute};
  spec.scenes = SceneDistribution{};
  return spec;
}

void write(benchmark::State& state) {
  const TemporaryFolder folder("timing");
  const DatasetSpec spec = training(state.range(0));
  std::uintmax_t bytes = 0;
  for (auto _ : state) {
    generate_dataset(spec, folder / "train.h5");
    state.PauseTiming();
    bytes = fs::file_size(folder / "train.h5");
    fs::remove(folder / "train.h5");
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(bytes));
}
BENCHMARK(write)
    ->Name("dataset/write")
    ->Arg(1000)
    ->Arg(10000)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void open(benchmark::State& state) {
  const TemporaryFolder folder("timing");
  generate_dataset(training(1000), folder / "train.h5");
  for (auto _ : state) benchmark::DoNotOptimize(DatasetFile(folder / "train.h5").size());
}
BENCHMARK(open)->Name("dataset/open")->Unit(benchmark::kMicrosecond);

/// Voltages, true images and scenes, which is what a trial reads.
void read(benchmark::State& state) {
  const TemporaryFolder folder("timing");
  generate_dataset(training(state.range(0)), folder / "train.h5");
  const DatasetFile file(folder / "train.h5");
  for (auto _ : state) {
    for (std::uint64_t first = 0; first < file.size(); first += block) {
      const std::uint64_t count = std::min(block, file.size() - first);
      benchmark::DoNotOptimize(file.voltages(first, count));
      benchmark::DoNotOptimize(file.conductivity(first, count));
      benchmark::DoNotOptimize(file.scenes(first, count));
    }
  }
  const std::int64_t numbers = state.range(0) * (file.sensor().channels() + file.sensor().pixels());
  const auto bytes = numbers * static_cast<std::int64_t>(sizeof(double));
  state.SetItemsProcessed(state.iterations() * state.range(0));
  state.SetBytesProcessed(state.iterations() * bytes);
  compare_with_limit(state, streaming_time(bytes), "stream");
}
BENCHMARK(read)->Name("dataset/read")->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ertbench

int main(int argc, char** argv) { return ertbench::run_benchmarks(argc, argv); }
