#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <list>
#include <optional>
#include <vector>

#include "bench/run/job_records.h"
#include "bench/run/stage.h"
#include "core/process.h"

namespace ertbench {

class Progress;

/// Runs the jobs of one stage in processes of their own, some at a time, and notes what failed.
class JobRunner {
 public:
  JobRunner(const Stage& stage, const Experiment& experiment, const Cache& cache,
            std::filesystem::path folder, JobRecords& records);

  /// What one job may take of a machine that others use too: so many threads, and as large a part
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

}  // namespace ertbench
