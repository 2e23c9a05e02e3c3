#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"

namespace ertbench {

struct RunOptions {
  std::filesystem::path out;      ///< result folder
  std::vector<std::string> only;  ///< labels to run, or those of whole sweeps; empty: all
  int jobs = 1;                   ///< accuracy stages at a time; clocks always run alone
  bool fresh = false;             ///< forget the records and the fitted solvers of this experiment
};

/// Runs an experiment: datasets, then each trial in a process of its own. What earlier runs
/// finished is not done again. Rows of trials that failed stay in the results with what happened.
ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options);

}  // namespace ertbench
