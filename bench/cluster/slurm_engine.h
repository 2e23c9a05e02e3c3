#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/cluster/slurm.h"
#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// A part that was given to sbatch, now or by an earlier command.
struct Submission {
  long job = 0;
  std::string part;
  std::vector<Units> elements;
};

/// Submissions of a result folder, in OUT/slurm/submitted.json: written after each sbatch, so that
/// the next command knows what waits and runs.
class Submissions {
 public:
  /// Empty if there is no file. Throws InputError if it is damaged.
  explicit Submissions(const std::filesystem::path& folder);

  void add(Submission one);
  std::vector<long> jobs() const;
  const std::vector<Submission>& all() const { return all_; }
  std::vector<long> jobs_of(const std::vector<std::string>& parts) const;
  const Submission* find(long job) const;
  /// The units of the tasks.
  LiveUnits units_of(const std::vector<SlurmTask>& tasks) const;
  /// Forgets the jobs that have ended.
  void keep(const std::vector<SlurmTask>& live);

 private:
  void write() const;

  std::filesystem::path file_;
  std::vector<Submission> all_;
};

struct SlurmOptions {
  std::filesystem::path out;      ///< result folder, on a file system that all nodes share
  std::vector<std::string> only;  ///< as in RunOptions
  std::string command;            ///< reproduces the results
  std::string partition;          ///< as for sbatch; empty: Slurm's default
  std::string time;
  std::string account;
  int array_limit = 0;   ///< elements of an array that run at the same time; 0: no limit
  int threads = 1;       ///< of an element, and number of cores it requests
  bool dry_run = false;  ///< print what would be submitted, and submit nothing
};

struct SlurmOutcome {
  bool reported = false;  ///< the job of the report wrote its files
  int failures = 0;       ///< jobs that failed or were lost, and figures that could not be drawn
};

/// Submits what is missing as arrays of jobs with dependencies, whose files are in OUT/slurm, then
/// watches until all have ended and prints the table. Ending this program ends none of the jobs;
/// the same command finds them again, continues watching, and resubmits lost ones by their missing
/// records. Throws InputError if Slurm refuses.
SlurmOutcome run_on_slurm(const Experiment& experiment, const Cache& cache,
                          const SlurmOptions& options);

/// The sbatch script of one part. `list`: the file of its units.
std::string slurm_script(const Experiment& experiment, const Cache& cache,
                         const SlurmOptions& options, const std::string& part, std::size_t elements,
                         bool exclusive, const std::filesystem::path& list);

}  // namespace ertbench
