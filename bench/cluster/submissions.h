#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/cluster/slurm.h"
#include "bench/cluster/slurm_plan.h"

namespace ertbench {

/// A part that was given to sbatch, now or by an earlier command.
struct Submission {
  long job = 0;
  std::string part;
  std::vector<Units> elements;
};

/// What was submitted for a result folder, in OUT/slurm/submitted.json: written after each sbatch,
/// so that the next command knows what waits and runs.
class Submissions {
 public:
  /// Empty where there are none. Throws InputError where the file is damaged.
  explicit Submissions(const std::filesystem::path& folder);

  void add(Submission one);
  std::vector<long> jobs() const;
  const std::vector<Submission>& all() const { return all_; }
  /// Of the jobs of these parts.
  std::vector<long> jobs_of(const std::vector<std::string>& parts) const;
  const Submission* find(long job) const;
  /// What the tasks make.
  LiveUnits units_of(const std::vector<SlurmTask>& tasks) const;
  /// Forgets the jobs that have ended.
  void keep(const std::vector<SlurmTask>& live);

 private:
  void write() const;

  std::filesystem::path file_;
  std::vector<Submission> all_;
};

}  // namespace ertbench
