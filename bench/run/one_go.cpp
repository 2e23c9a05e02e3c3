#include "bench/run/one_go.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/record/provenance.h"
#include "bench/run/job_records.h"
#include "bench/run/stage.h"
#include "core/atomic_file.h"
#include "core/build_stamp.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// Clocks that were read later are of another go.
constexpr std::chrono::hours longest{12};

bool has_record(const JobRecords& records, const Job& job) {
  return static_cast<bool>(records.find(job).record);
}

/// Names the jobs and what determines their records.
std::string hash_of_jobs(const Stage& stage, const Experiment& experiment,
                         const std::vector<Job>& jobs) {
  std::string all;
  for (const Job& job : jobs) {
    all.append(job.name).append(" ").append(stage.key(experiment, job)).append("\n");
  }
  return hash_of(all);
}

}  // namespace

OneGo::OneGo(const Stage& stage, const Experiment& experiment, const fs::path& folder,
             const JobRecords& records, const std::vector<Job>& due, const std::vector<Job>& wanted)
    : jobs_(wanted) {
  if (!stage.in_one_go()) return;
  const auto missing = std::count_if(wanted.begin(), wanted.end(),
                                     [&](const Job& job) { return !has_record(records, job); });
  if (missing == 0) return;
  std::set<std::string> names;
  for (const Job& job : wanted) names.insert(job.name);
  jobs_ = due;
  std::erase_if(jobs_, [&](const Job& job) {
    return names.count(job.name) == 0 && !has_record(records, job);
  });
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

void OneGo::finish() const {
  std::error_code ignored;
  if (!mark_.empty()) fs::remove(mark_, ignored);
}

}  // namespace ertbench
