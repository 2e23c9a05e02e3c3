#pragma once

namespace ertbench {

/// The main function of a benchmark program: runs what is registered, as Google Benchmark's options
/// say, and notes in the context of its output how ertbench itself was built ("debug" there is how
/// Debian built Google Benchmark). Returns the exit code.
int run_benchmarks(int argc, char** argv);

}  // namespace ertbench
