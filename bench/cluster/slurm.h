#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/run/runner.h"

namespace ertbench {

/// A waiting or running task of Slurm: a job, or an element of an array.
struct SlurmTask {
  long job = 0;                ///< number given by sbatch
  std::optional<int> element;  ///< of an array
  std::string state;           ///< "PENDING", "RUNNING", ...
  std::string node;            ///< empty while it waits

  bool waits() const { return state == "PENDING"; }
};

/// Parses the output of `squeue -h -o "%F|%K|%T|%N"`: a line for each task, with waiting elements
/// of an array in one line as ranges ("3,7-9%2", with a step "0-8:4"). Throws InputError for a line
/// that is malformed or cut short ("...").
std::vector<SlurmTask> tasks_from(const std::string& text);

/// The tasks of these jobs that have not ended. Throws InputError if squeue fails.
std::vector<SlurmTask> live_tasks(std::span<const long> jobs);

/// Runs the command line of an sbatch with --parsable and returns the job's number. Throws
/// InputError with sbatch's message.
long submit(const std::vector<std::string>& command);

/// Ends jobs that wait or run; those that ended meanwhile are no error.
void cancel(std::span<const long> jobs);

/// The largest number of elements of an array in this Slurm (MaxArraySize of slurm.conf(5)); its
/// default if it does not answer.
int most_elements();

/// Names of what an element of an array makes: datasets; entries ("dd-ert.seed2") to fit and score;
/// labels to time or to take up ladders.
using Units = std::vector<std::string>;

/// One sbatch: an array, or a job of one element.
struct SlurmPart {
  std::string name;             ///< "datasets", a stage's name, or "report"
  std::vector<Units> elements;  ///< the report has one without units
  bool exclusive = false;       ///< needs a node of its own
};

/// Part and unit of what waits or runs already and is not planned again.
using LiveUnits = std::set<std::pair<std::string, std::string>>;

/// Of a run; its result folder is on a file system that all nodes share.
struct SlurmOptions : RunOptions {
  std::string partition;  ///< as for sbatch; empty: Slurm's default
  std::string time;
  std::string account;
  int array_limit = 0;   ///< elements of an array that run at the same time; 0: no limit
  int threads = 1;       ///< of an element, and number of cores it requests
  bool dry_run = false;  ///< print what would be submitted, and submit nothing
};

/// Number of labels timed together on one node; most experiments fit.
inline constexpr std::size_t most_timed_together = 64;

/// Plans what is missing, by the records in the result folder and the datasets in the cache, in the
/// order of making. The report always comes last, alone if nothing is missing. `experiment` has
/// every entry described as read_experiment does. `most_elements`: of an array; more units share
/// elements.
std::vector<SlurmPart> slurm_plan(const Experiment& experiment, const Cache& cache,
                                  const LiveUnits& live, const SlurmOptions& options,
                                  int most_elements);

/// Arguments of one element of an array, and of the run, for the report.
struct ElementOptions : RunOptions {
  std::string part;  ///< SlurmPart::name
  Units units;
  int threads = 1;  ///< of each process
};

/// Makes the units one after another on this machine, each in a child process as `run` does; units
/// with a record are skipped. Failures are written beside the record's place (`NAME.failed.json`)
/// for the report. Returns the number of failed jobs.
int run_element(const Experiment& experiment, const Cache& cache, const ElementOptions& options);

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
  std::vector<long> jobs_of(const std::vector<std::string>& parts) const;
  const Submission* find(long job) const;
  /// The units of the tasks.
  LiveUnits units_of(const std::vector<SlurmTask>& tasks) const;
  /// Forgets the jobs that have ended.
  void keep(const std::vector<SlurmTask>& live);

 private:
  std::filesystem::path file_;
  std::vector<Submission> all_;
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
