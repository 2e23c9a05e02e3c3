#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "bench/experiment/experiment.h"
#include "bench/experiment/solver_entry.h"
#include "bench/record/result_row.h"
#include "core/build_stamp.h"
#include "core/json.h"
#include "core/seconds.h"

namespace ertbench {

/// Which datasets, fitted solvers and records of earlier runs are taken as they are. In every case
/// their recipe, their keys, must be the same.
enum class Reuse {
  same_code,     ///< those whose probes are still what this program computes
  same_program,  ///< those of this very program (`--rebuild-stale`)
  clean,         ///< of these those from builds whose sources were committed (`publish`)
};

/// "same-code", "same-program", "clean": of `ertbench trial --reuse`.
const char* name_of(Reuse reuse);
/// The inverse. Throws InputError for another name.
Reuse reuse_from_name(const std::string& name);

/// Why something is not to be reused, "the probe solver/tsvd differs by 0.31 of its norm (commit
/// 0123456789ab)"; empty where it may be. `made`: the build that made it, none where it does not
/// say; `now`: this one, with the probes that such things depend on.
std::string why_stale(const std::optional<BuildStamp>& made, const BuildStamp& now, Reuse reuse);

std::string cpu_name();
std::string host_name();
/// Now, "2026-01-31T12:00:00Z".
std::string utc_now();

/// Describes the machine and build: commit, host, system, cpu, cores, compiler, library versions,
/// date.
nlohmann::json machine_provenance();

/// Returns what a reviewer needs to reproduce a result: commit, host, cpu, threads, library
/// versions, seeds, and the full recipe of every dataset. "date" is when the last of the numbers
/// was measured, "measured" when the first and the last were, "rendered" when the tables were
/// written.
nlohmann::json provenance(const Experiment& experiment, int jobs, const DateRange& measured);

/// State of a running trial.
struct TrialProgress {
  double fraction = 0;      ///< done, 0 ... 1
  std::string text;         ///< the solver's: "epoch 5 of 12, validation error 0.412"
  double seconds_left = 0;  ///< 0 where there is no telling
};

/// A small file by which a trial's process tells the runner what it does: written whole at most
/// twice a second, removed in the end. A file that cannot be written is no reason to fail.
class ProgressFile {
 public:
  explicit ProgressFile(std::filesystem::path file);
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;
  ~ProgressFile();

  void update(std::uint64_t done, std::uint64_t total, const std::string& text);

 private:
  std::filesystem::path file_;
  std::optional<SteadyClock::time_point> start_;  ///< of the first update
  std::uint64_t first_done_ = 0;                  ///< then; a fit may go on where it stopped
  SteadyClock::time_point last_;
};

/// Removes the file of a trial that could not do so itself, as it crashed or was killed.
void remove_progress(const std::filesystem::path& file);

/// Nothing where there is no such file, or none that can be read.
std::optional<TrialProgress> read_progress(const std::filesystem::path& file);

/// Version of what the records of accuracy and timing hold; part of their keys.
inline constexpr int record_schema = 4;

/// The record of a job in a result folder: `folder`/records/tsvd.accuracy.json, where
/// "tsvd.accuracy" is the job's name. Its log and its progress stand beside it under other endings.
std::filesystem::path record_file(const std::filesystem::path& folder, const std::string& job,
                                  const std::string& ending = ".json");

/// Ending of the file in which a job's process leaves its record; the runner renames it when that
/// has ended well, as what a process wrote that crashed afterwards is not to be trusted.
inline constexpr const char* written_ending = ".written.json";

/// Ending of the file in which a job's process says how it failed, where it knows: `{"status",
/// "message"}`.
inline constexpr const char* failure_ending = ".failure.json";

/// Puts the key, a hash of all that determines the record, the build and the date into the record
/// and writes it: aside first, then renamed into place.
void write_record(const std::filesystem::path& file, nlohmann::json record, const std::string& key,
                  const BuildStamp& build);

/// A record found on disk, or why there is none.
struct FoundRecord {
  JsonValue record;     ///< null: the job is to be done again
  std::string why_not;  ///< why not what is there; empty where there is nothing
};

/// The record of that key, where it may be reused: its "build" is what made it, its "fit_build",
/// where it has one, what fitted the solver.
FoundRecord find_record(const std::filesystem::path& file, const std::string& key,
                        const BuildStamp& now, Reuse reuse);

// The stamps of what this program makes: for each kind of thing the probes that it depends on.

BuildStamp stamp_of_dataset(const DatasetSpec& spec);

/// Its solver's probe, those of the sets that it learns from, and the user's libraries.
BuildStamp stamp_of_fit(const FitRecipe& recipe);

/// The scores, the datasets of the experiment, and the solver of the job's entry, null where a job
/// runs none; with ladders or faults the front, too.
BuildStamp stamp_of_record(const Experiment& experiment, const SolverEntry* entry);

/// The probe "limit" where this program has computed it, which `ertbench limit` does, and those of
/// the test set and of the set whose scenes are the prior.
BuildStamp stamp_of_limit(const DatasetSpec& set, const DatasetSpec& scenes);

/// Today's values of the probes that a stamp carries; those that it does not know are left out.
Probes current_probes(const BuildStamp& made);

/// All probes below the limit's.
Probes all_probes();

}  // namespace ertbench
