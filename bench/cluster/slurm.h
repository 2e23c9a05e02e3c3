#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

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

/// What an element of an array makes, by name: datasets; entries ("dd-ert.seed2") to be fitted and
/// scored; labels to be timed or to climb ladders.
using Units = std::vector<std::string>;

/// One sbatch: an array, or a job of one element.
struct SlurmPart {
  std::string name;             ///< "datasets", a stage's name, or "report"
  std::vector<Units> elements;  ///< of the report one without units
  bool exclusive = false;       ///< its node is its own
};

/// What is not to be planned: it waits or runs already.
struct LiveUnits {
  std::set<std::pair<std::string, std::string>> units;  ///< part and unit

  bool has(const std::string& part, const std::string& unit) const {
    return units.count({part, unit}) > 0;
  }
};

struct SlurmPlanSettings {
  std::filesystem::path out;      ///< result folder
  std::vector<std::string> only;  ///< as of RunOptions
  int most_elements = 1001;       ///< of an array; more units than that share elements
};

/// Labels that are timed in one go, on one node: enough for most experiments to be all on one.
inline constexpr std::size_t most_timed_together = 64;

/// What is missing, by the records in the result folder and the datasets in the cache, in the order
/// in which it is to be made; the report always comes last, alone where nothing is missing.
/// `experiment` has every entry described as read_experiment does.
std::vector<SlurmPart> slurm_plan(const Experiment& experiment, const Cache& cache,
                                  const LiveUnits& live, const SlurmPlanSettings& settings);

/// The experiment with those solvers alone whose entry or label is a unit of the list.
Experiment restricted_to(const Experiment& experiment, const Units& units);

}  // namespace ertbench
