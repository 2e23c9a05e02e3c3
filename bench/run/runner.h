#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
#include "bench/run/stages.h"

namespace ertbench {

struct RunOptions {
  std::filesystem::path out;      ///< result folder
  std::vector<std::string> only;  ///< labels to run, or those of whole sweeps; empty: all
  int jobs = 1;                   ///< processes at a time; stages that read the clock run one alone
  std::string command;            ///< that makes the results again; empty: that of all of the file
  bool fresh = false;             ///< forget the records and the fitted solvers of this experiment
};

/// Runs the stages one after another: the datasets they need, then each job in a process of its
/// own. What earlier runs finished is not done again. Jobs that failed stay in the results with
/// what happened.
ExperimentResults run_stages(const Stages& stages, const Experiment& experiment, const Cache& cache,
                             const RunOptions& options);

/// The results of the records that are there; nothing is run. `why_missing` says what became of a
/// job without one, nothing where nobody asked for it.
ExperimentResults collect_stages(
    const Stages& stages, const Experiment& experiment, const Cache& cache,
    const RunOptions& options,
    const std::function<std::optional<Failure>(const Job& job)>& why_missing);

/// The same as run_stages with the stages of `ertbench run`.
ExperimentResults run_experiment(const Experiment& experiment, const Cache& cache,
                                 const RunOptions& options);

/// Has every stage write its own files into the folder; returns their sections of the page.
std::vector<ReportSection> report_stages(const Stages& stages, const Experiment& experiment,
                                         const ExperimentResults& results,
                                         const std::filesystem::path& folder);

/// The same with the stages of `ertbench run`, then tables, figures and the page of the experiment;
/// prints the table. Returns how many figures could not be drawn.
std::size_t report_experiment(const Experiment& experiment, const Cache& cache,
                              const ExperimentResults& results,
                              const std::filesystem::path& folder);

}  // namespace ertbench
