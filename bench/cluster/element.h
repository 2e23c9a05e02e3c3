#pragma once

#include <filesystem>
#include <string>

#include "bench/cluster/slurm.h"

namespace ertbench {

/// Arguments of one element of an array.
struct ElementOptions {
  std::string part;  ///< SlurmPart::name
  Units units;
  std::filesystem::path out;
  std::vector<std::string> only;  ///< as in RunOptions, for the report
  std::string command;            ///< reproduces the results
  int threads = 1;                ///< of each process
};

/// Makes the units one after another on this machine, each in a child process as `run` does; units
/// with a record are skipped. Failures are written beside the record's place (`NAME.failed.json`)
/// for the report. Returns the number of failed jobs.
int run_element(const Experiment& experiment, const Cache& cache, const ElementOptions& options);

/// Ending of the file in which an element notes a failure.
inline constexpr const char* failed_ending = ".failed.json";

}  // namespace ertbench
