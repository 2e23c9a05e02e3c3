#include "bench/run/job_records.h"

#include <nlohmann/json.hpp>

#include "bench/run/stage.h"
#include "core/errors.h"
#include "core/replace_file.h"

namespace ertbench {

JobRecords::JobRecords(const Stage& stage, const Experiment& experiment,
                       std::filesystem::path folder, Reuse reuse)
    : stage_(stage), experiment_(experiment), folder_(std::move(folder)), reuse_(reuse) {}

std::filesystem::path JobRecords::file(const Job& job, const std::string& ending) const {
  return record_file(folder_, job.name, ending);
}

FoundRecord JobRecords::find(const Job& job) const {
  FoundRecord found = find_record(file(job), stage_.key(experiment_, job),
                                  stamp_of_records(experiment_.plugins), reuse_);
  if (!found.record) return found;
  try {
    stage_.check(experiment_, *found.record);
  } catch (const std::exception& error) {
    return {JsonValue(), std::string("it cannot be read: ") + error.what()};
  }
  if (const std::string why = stage_.why_not_here(*found.record); !why.empty()) {
    return {JsonValue(), why};
  }
  return found;
}

void JobRecords::expect(const Job& job) { expected_.insert(job.name); }

bool JobRecords::accept(const Job& job) {
  const std::filesystem::path written = file(job, written_ending);
  if (!std::filesystem::exists(written)) return false;
  put_in_place(written, file(job));
  const bool good = static_cast<bool>(find(job).record);
  if (good) expect(job);
  return good;
}

void JobRecords::discard(const Job& job) const {
  std::error_code ignored;
  std::filesystem::remove(file(job, written_ending), ignored);
}

std::optional<nlohmann::json> JobRecords::read(const Job& job) const {
  const FoundRecord found = find(job);
  if (found.record) return *found.record;
  if (expected_.count(job.name) > 0) {
    throw InputError(file(job).string() + ": was there a moment ago and cannot be read now" +
                     (found.why_not.empty() ? "" : ": " + found.why_not) +
                     "; give the same command again");
  }
  return std::nullopt;
}

void JobRecords::add_failure(const Job& job, Failure failure) {
  failures_.emplace(job.subject, std::move(failure));
}

const Failure* JobRecords::failure(const Job& job) const {
  const auto found = failures_.find(job.subject);
  return found == failures_.end() ? nullptr : &found->second;
}

Failure JobRecords::why_missing(const Job& job) const {
  const Failure* found = failure(job);
  return found ? *found : Failure{"not run", "left out by --only"};
}

}  // namespace ertbench
