#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ertbench {

/// A task that Slurm has not ended yet: a job, or an element of an array.
struct SlurmTask {
  long job = 0;                ///< the number that sbatch gave
  std::optional<int> element;  ///< of an array
  std::string state;           ///< "PENDING", "RUNNING", ...
  std::string node;            ///< empty while it waits

  bool waits() const { return state == "PENDING"; }
};

/// The words of `squeue -h -o "%F|%K|%T|%N"`: a line for each task, the elements of an array that
/// wait in one line as ranges ("3,7-9%2", with a step "0-8:4"). Throws InputError for a line that
/// is none, or that is cut short ("...").
std::vector<SlurmTask> tasks_from(const std::string& text);

/// Those of these jobs that have not ended. Throws InputError where squeue fails.
std::vector<SlurmTask> live_tasks(std::span<const long> jobs);

/// Runs the command line of an sbatch with --parsable and returns the job's number. Throws
/// InputError with what sbatch says.
long submit(const std::vector<std::string>& command);

/// Ends jobs that wait or run; those that ended meanwhile are no error.
void cancel(std::span<const long> jobs);

/// The most elements that this Slurm lets an array have; its default where it cannot be asked.
int most_elements();
inline constexpr int default_most_elements = 1001;  ///< MaxArraySize of slurm.conf(5)

}  // namespace ertbench
