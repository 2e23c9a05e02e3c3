#include "bench/run/runner.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/record/limit_file.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "core/build_stamp.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// Clocks that were read later are of another go.
constexpr std::chrono::hours longest{12};

/// Names the jobs and what determines their records.
std::string hash_of_jobs(const Stage& stage, const Experiment& experiment,
                         const std::vector<Job>& jobs) {
  std::string all;
  for (const Job& job : jobs) {
    all.append(job.name).append(" ").append(stage.key(experiment, job)).append("\n");
  }
  return hash_of(all);
}

/// Results say which builds made them; the probes stay with the records.
void add_once(BuildStamp stamp, std::vector<BuildStamp>& stamps) {
  stamp.probes.clear();
  if (std::ranges::find(stamps, stamp) == stamps.end()) stamps.push_back(stamp);
}

std::optional<BuildStamp> stamp_in(const nlohmann::json& record, const char* key) {
  return record.contains(key) ? build_stamp_from_json(record.at(key)) : std::nullopt;
}

/// --only names solvers: jobs that run none are always wanted.
std::vector<Job> wanted(std::vector<Job> jobs, const std::vector<std::string>& only) {
  std::erase_if(jobs, [&](const Job& job) { return job.entry && !job.entry->is_wanted(only); });
  return jobs;
}

void forget(const Stages& stages, const Experiment& experiment, const Cache& cache,
            const RunOptions& options) {
  for (const std::unique_ptr<Stage>& stage : stages) {
    const JobRecords records(*stage, experiment, options.out);
    for (const Job& job : wanted(stage->jobs(experiment), options.only)) {
      fs::remove(records.file(job));
      stage->forget(experiment, cache, job);
    }
  }
}

/// Stage by stage: `work` sees to the records, then they are collected.
template <typename Work>
ExperimentResults gather(const Stages& stages, const Experiment& experiment, const Cache& cache,
                         const RunOptions& options, const Work& work) {
  ExperimentResults results;
  results.jobs = options.jobs;
  results.command = options.command;
  for (const std::unique_ptr<Stage>& stage : stages) {
    JobRecords records(*stage, experiment, options.out, cache.reuse());
    work(*stage, results, records);
    stage->collect(experiment, cache, records, results);
    add_builds(*stage, experiment, records, results);
    results.failures += records.failures();
  }
  if (!results.rows.empty()) {
    const DatasetSpec* training = experiment.training ? &*experiment.training : nullptr;
    add_limit_rows(options.out, {experiment.tests, training}, cache.reuse(), results.rows);
    compare_with_limits(options.out, results.frames, results.rows);
  }
  return results;
}

/// The folder of results while a run writes into it.
class TakenFolder {
 public:
  /// Throws InputError if another run writes into it.
  explicit TakenFolder(const fs::path& out) {
    fs::create_directories(out / "records");
    const std::string file = (out / ".running").string();
    descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
    if (descriptor_ < 0) {
      throw InputError(printable_path(file) + ": cannot be written: " + std::strerror(errno) +
                       "; check that the folder is writable");
    }
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      char process[24] = {};
      static_cast<void>(::pread(descriptor_, process, sizeof process - 1, 0));
      ::close(descriptor_);
      throw InputError(printable_path(out.string()) + ": process " + printable(process) +
                       " is running into this folder; wait for its end, or name another by --out");
    }
    const std::string own = std::to_string(::getpid());
    static_cast<void>(::ftruncate(descriptor_, 0));
    static_cast<void>(::pwrite(descriptor_, own.data(), own.size(), 0));
  }
  TakenFolder(const TakenFolder&) = delete;
  TakenFolder& operator=(const TakenFolder&) = delete;
  ~TakenFolder() {
    static_cast<void>(::ftruncate(descriptor_, 0));
    ::close(descriptor_);
  }

 private:
  int descriptor_ = -1;
};

}  // namespace

TimingSession::TimingSession(const Stage& stage, const Experiment& experiment,
                             const fs::path& folder, const JobRecords& records,
                             const std::vector<Job>& due, const std::vector<Job>& wanted)
    : jobs_(wanted) {
  if (!stage.in_one_session()) return;
  const auto missing =
      std::ranges::count_if(wanted, [&](const Job& job) { return !records.has(job); });
  if (missing == 0) return;
  std::set<std::string> names;
  for (const Job& job : wanted) names.insert(job.name);
  jobs_ = due;
  std::erase_if(jobs_,
                [&](const Job& job) { return names.count(job.name) == 0 && !records.has(job); });
  mark_ = record_file(
      folder, stage.name() + "-" + hash_of_jobs(stage, experiment, jobs_).substr(0, 16), ".begun");
  if (fs::exists(mark_) &&
      fs::file_time_type::clock::now() - fs::last_write_time(mark_) < longest) {
    return;  // goes on
  }
  const auto kept = std::ssize(jobs_) - missing;
  if (kept > 0) {
    spdlog::info(
        "{}: {} {}s have no record; with them all others are made again, as clocks are "
        "compared only where they were read in one go",
        stage.name(), missing, stage.noun());
  }
  for (const Job& job : jobs_) fs::remove(records.file(job));
  write_file_atomically(mark_, utc_now() + "\n");
}

void TimingSession::finish() const {
  std::error_code ignored;
  if (!mark_.empty()) fs::remove(mark_, ignored);
}

void add_builds(const Stage& stage, const Experiment& experiment, const JobRecords& records,
                ExperimentResults& results) {
  for (const Job& job : stage.due(experiment, results)) {
    const auto record = records.read(job);
    if (!record) continue;
    results.measured.add(record->value("date", ""));
    const auto made = stamp_in(*record, "build");
    const auto fitted = stamp_in(*record, "fit_build");
    if (made) add_once(*made, results.builds[stage.name()]);
    if (fitted) add_once(*fitted, results.builds["fits"]);
    for (ResultRow& row : results.rows) {
      if (!job.entry || row.label != job.entry->label) continue;
      if (made && stage.wants_machine_alone()) add_once(*made, row.build.timed);
      if (made && fitted) add_once(*made, row.build.scored);
      if (fitted) add_once(*fitted, row.build.fitted);
    }
  }
  // The rows without a solver are made with the results.
  const BuildStamp now = stamp_of_this_build({}, experiment.plugins);
  for (ResultRow& row : results.rows) {
    if (row.type == "truth" || row.type == "no-contact") row.build.scored = {now};
  }
}

ExperimentResults run_stages(const Stages& stages, const Experiment& experiment, const Cache& cache,
                             const RunOptions& options) {
  const auto taken = std::make_shared<const TakenFolder>(options.out);
  const CacheShare share(cache, CacheShare::Of::run);
  if (options.fresh) forget(stages, experiment, cache, options);
  if (std::ranges::any_of(stages, [](const auto& stage) { return stage->reads_datasets(); })) {
    ensure_datasets(experiment, cache);
  }
  ExperimentResults all =
      gather(stages, experiment, cache, options,
             [&](const Stage& stage, const ExperimentResults& results, JobRecords& records) {
               const std::vector<Job> due = stage.due(experiment, results);
               const TimingSession session(stage, experiment, options.out, records, due,
                                           wanted(due, options.only));
               JobRunner(stage, experiment, cache, options.out, records)
                   .run(session.jobs(), stage.wants_machine_alone() ? 1 : options.jobs);
               if (records.failures() == 0) session.finish();
             });
  all.folder = taken;
  return all;
}

ExperimentResults collect_stages(
    const Stages& stages, const Experiment& experiment, const Cache& cache,
    const RunOptions& options,
    const std::function<std::optional<Failure>(const Job& job)>& why_missing) {
  return gather(stages, experiment, cache, options,
                [&](const Stage& stage, const ExperimentResults& results, JobRecords& records) {
                  for (const Job& job : wanted(stage.due(experiment, results), options.only)) {
                    if (records.has(job)) {
                      records.expect(job);
                    } else if (auto failure = why_missing(job)) {
                      records.add_failure(job, std::move(*failure));
                    }
                  }
                });
}

std::vector<ReportSection> report_stages(const Stages& stages, const Experiment& experiment,
                                         const ExperimentResults& results, const fs::path& folder) {
  std::vector<ReportSection> sections;
  for (const std::unique_ptr<Stage>& stage : stages) {
    const std::vector<ReportSection> own = stage->report(experiment, results, folder);
    sections.insert(sections.end(), own.begin(), own.end());
  }
  return sections;
}

}  // namespace ertbench
