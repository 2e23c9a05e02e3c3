#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/cache.h"
#include "bench/experiment.h"

namespace ertbench {

struct RunOptions {
  std::filesystem::path out;      ///< result folder
  std::vector<std::string> only;  ///< labels to run, or those of whole sweeps; empty: all
  int jobs = 1;                   ///< accuracy stages at a time; clocks always run alone
  bool fresh = false;             ///< forget the records and the fitted solvers of this experiment
};

/// Runs an experiment: datasets, then each trial in a process of its own, then summary.json, tables
/// and figure in the result folder. What earlier runs finished is not done again. Returns the
/// number of trials that failed; their rows stay in all results with what happened.
int run_experiment(const Experiment& experiment, const Cache& cache, const RunOptions& options);

}  // namespace ertbench
