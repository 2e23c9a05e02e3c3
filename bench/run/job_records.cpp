#include "bench/run/job_records.h"

#include <nlohmann/json.hpp>

#include "bench/record/record_file.h"
#include "bench/run/stage.h"

namespace ertbench {

JobRecords::JobRecords(const Stage& stage, const Experiment& experiment,
                       std::filesystem::path folder)
    : stage_(stage), experiment_(experiment), folder_(std::move(folder)) {}

std::filesystem::path JobRecords::file(const Job& job, const std::string& ending) const {
  return record_file(folder_, job.name, ending);
}

bool JobRecords::has(const Job& job) const { return read(job).has_value(); }

std::optional<nlohmann::json> JobRecords::read(const Job& job) const {
  std::optional<nlohmann::json> record = read_record(file(job), stage_.key(experiment_, job));
  if (!record) return std::nullopt;
  try {
    stage_.check(experiment_, *record);
  } catch (const std::exception&) {  // not a record of ours: made again
    return std::nullopt;
  }
  return record;
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
