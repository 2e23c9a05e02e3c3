#pragma once

#include <filesystem>
#include <vector>

#include "bench/run/job.h"

namespace ertbench {

class JobRecords;
class Stage;
struct Experiment;

/// The jobs of a stage whose records are worth comparing only where they were made in one go
/// (Stage::in_one_go): a clock that was read on another day, beside other programs, is another
/// clock. Where a wanted job has no record, those of all others that have one are made again with
/// it. A go that was interrupted, or in which a job failed, is taken up again on the same day; its
/// mark in the folder of records tells.
class OneGo {
 public:
  /// `due`: all jobs of the stage; `wanted`: those asked for. Removes what is to be made again.
  OneGo(const Stage& stage, const Experiment& experiment, const std::filesystem::path& folder,
        const JobRecords& records, const std::vector<Job>& due, const std::vector<Job>& wanted);

  /// Those to be given to the runner, which leaves out what has a record.
  const std::vector<Job>& jobs() const { return jobs_; }
  /// All of them have records.
  void finish() const;

 private:
  std::vector<Job> jobs_;
  std::filesystem::path mark_;  ///< empty where nothing is to be made
};

}  // namespace ertbench
