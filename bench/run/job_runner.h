#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <list>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/record/record_file.h"
#include "bench/run/stage.h"
#include "core/process.h"

namespace ertbench {

/// The records that the jobs of one stage left in a result folder, now or earlier, and what failed
/// just now.
class JobRecords {
 public:
  JobRecords(const Stage& stage, const Experiment& experiment, std::filesystem::path folder,
             Reuse reuse = Reuse::same_code);

  /// The job's file; its log and its progress have other endings.
  std::filesystem::path file(const Job& job, const std::string& ending = ".json") const;
  /// The job's record, of the right key and one that the stage can read, where it may be reused.
  FoundRecord find(const Job& job) const;
  bool has(const Job& job) const { return static_cast<bool>(find(job).record); }
  /// Puts the record that the job's process has written, which ended well, into its place; whether
  /// there was one.
  bool accept(const Job& job);
  /// The job has a record. Where that cannot be read later on, its row must not pass for one that
  /// nobody asked for.
  void expect(const Job& job) { expected_.insert(job.name); }
  /// Removes what a process wrote that did not.
  void discard(const Job& job) const;
  /// Nothing where it has none. Throws InputError where one is expected.
  std::optional<nlohmann::json> read(const Job& job) const;

  void add_failure(const Job& job, Failure failure);
  /// Failure of the job's subject, in this round or another; null where nothing did.
  const Failure* failure(const Job& job) const;
  /// The same, or that the job was not run, as --only asks for others.
  Failure why_missing(const Job& job) const;
  int failures() const { return static_cast<int>(failures_.size()); }

 private:
  const Stage& stage_;
  const Experiment& experiment_;
  std::filesystem::path folder_;
  Reuse reuse_;
  std::map<std::string, Failure> failures_;  ///< by subject
  std::set<std::string> expected_;           ///< names of jobs that have a record
};

/// Runs the jobs of one stage in processes of their own, some at a time, and notes what failed.
class JobRunner {
 public:
  JobRunner(const Stage& stage, const Experiment& experiment, const Cache& cache,
            std::filesystem::path folder, JobRecords& records);

  /// Share of a machine that one job may take beside others: so many threads, and as large a part
  /// of the memory as they are of the cores. Without it the machine is shared out among the jobs.
  void take_only(int threads) { threads_ = threads; }

  /// Those that have no record yet, at most `at_a_time` together.
  void run(const std::vector<Job>& jobs, int at_a_time);

 private:
  struct Running {
    Job job;
    ProcessLimits limits;
    ChildProcess process;
  };

  /// Says, too, what is reused of earlier builds and what is not, and why.
  std::deque<Job> without_records(const std::vector<Job>& jobs) const;
  ProcessLimits limits(std::size_t at_a_time) const;
  Running start(const Job& job, std::size_t at_a_time) const;
  void start_some(std::deque<Job>& waiting, std::size_t at_a_time);
  void finish_some();
  void finish(const Running& one, const ProcessEnd& end);
  void show(Progress& progress, std::size_t total) const;

  const Stage& stage_;
  const Experiment& experiment_;
  const Cache& cache_;
  std::filesystem::path folder_;
  JobRecords& records_;
  std::filesystem::path program_;
  std::list<Running> running_;
  std::size_t done_ = 0;
  std::optional<int> threads_;
};

/// Does the work of `ertbench trial` in a process of its own: runs the stage's job of this name and
/// writes its record into the result folder; meanwhile its progress stands beside it. Throws
/// InputError where the stage has no such job. The entry of the job's solver is described
/// (experiment_solvers.h); those of the others need not be, and their plugins are not loaded.
void run_trial(const Stage& stage, const std::string& job, Experiment& experiment,
               const Cache& cache, SolverRegistry& registry, int threads,
               const std::filesystem::path& folder);

}  // namespace ertbench
