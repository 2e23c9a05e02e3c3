#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/record/experiment_results.h"
#include "bench/run/job_runner.h"
#include "bench/run/stage.h"

namespace ertbench {

/// The jobs of a stage whose records are worth comparing only where they were measured in one
/// session (Stage::in_one_session): a clock that was read on another day, beside other programs, is
/// another clock. Where a wanted job has no record, those of all others that have one are made
/// again with it. A session that was interrupted, or in which a job failed, is taken up again on
/// the same day; its mark in the folder of records tells.
class TimingSession {
 public:
  /// `due`: all jobs of the stage; `wanted`: those asked for. Removes what is to be made again.
  TimingSession(const Stage& stage, const Experiment& experiment,
                const std::filesystem::path& folder, const JobRecords& records,
                const std::vector<Job>& due, const std::vector<Job>& wanted);

  /// Those to be given to the runner, which leaves out what has a record.
  const std::vector<Job>& jobs() const { return jobs_; }
  /// All of them have records.
  void finish() const;

 private:
  std::vector<Job> jobs_;
  std::filesystem::path mark_;  ///< empty where nothing is to be made
};

/// Notes in the results which builds made the stage's records: in the rows of each job's solver,
/// and in the list of all.
void add_builds(const Stage& stage, const Experiment& experiment, const JobRecords& records,
                ExperimentResults& results);

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

/// Has every stage write its own files into the folder; returns their sections of the page.
std::vector<ReportSection> report_stages(const Stages& stages, const Experiment& experiment,
                                         const ExperimentResults& results,
                                         const std::filesystem::path& folder);

}  // namespace ertbench
