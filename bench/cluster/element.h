#pragma once

#include <filesystem>
#include <string>

#include "bench/cluster/slurm.h"

namespace ertbench {

/// What one element of an array is told.
struct ElementOptions {
  std::string part;  ///< SlurmPart::name
  Units units;
  std::filesystem::path out;
  std::vector<std::string> only;  ///< of the report, as of RunOptions
  std::string command;            ///< that makes the results again
  int threads = 1;                ///< of each process
};

/// Makes the units one after another on this machine, each in a process of its own, as `run` does;
/// what has a record is not made again. What failed stands beside the record's place
/// (`NAME.failed.json`), for the report to say. Returns how many jobs failed.
int run_element(const Experiment& experiment, const Cache& cache, const ElementOptions& options);

/// Of the file in which an element says what failed.
inline constexpr const char* failed_ending = ".failed.json";

}  // namespace ertbench
