#include "bench/cluster/submissions.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/errors.h"
#include "core/json_reader.h"

namespace ertbench {

using nlohmann::json;

Submissions::Submissions(const std::filesystem::path& folder) : file_(folder / "submitted.json") {
  if (!std::filesystem::exists(file_)) return;
  try {
    const json content = read_json_file(file_);
    for (const json& one : content.at("submissions")) {
      all_.push_back({one.at("job").get<long>(), one.at("part").get<std::string>(),
                      one.at("elements").get<std::vector<Units>>()});
    }
  } catch (const std::exception& error) {
    throw InputError(file_.string() + ": cannot be read (" + error.what() +
                     "); end the experiment's jobs (scancel) and remove the file");
  }
}

void Submissions::add(Submission one) {
  all_.push_back(std::move(one));
  write();
}

void Submissions::write() const {
  json list = json::array();
  for (const Submission& one : all_) {
    list.push_back({{"job", one.job}, {"part", one.part}, {"elements", one.elements}});
  }
  write_file_atomically(file_, json_text(json{{"schema", 1}, {"submissions", list}}));
}

std::vector<long> Submissions::jobs() const {
  std::vector<long> out;
  for (const Submission& one : all_) out.push_back(one.job);
  return out;
}

std::vector<long> Submissions::jobs_of(const std::vector<std::string>& parts) const {
  std::vector<long> out;
  for (const Submission& one : all_) {
    if (std::find(parts.begin(), parts.end(), one.part) != parts.end()) out.push_back(one.job);
  }
  return out;
}

const Submission* Submissions::find(long job) const {
  const auto found =
      std::find_if(all_.begin(), all_.end(), [&](const Submission& one) { return one.job == job; });
  return found == all_.end() ? nullptr : &*found;
}

LiveUnits Submissions::units_of(const std::vector<SlurmTask>& tasks) const {
  LiveUnits live;
  for (const SlurmTask& task : tasks) {
    const Submission* one = find(task.job);
    if (!one) continue;
    const auto element = static_cast<std::size_t>(task.element.value_or(0));
    if (element >= one->elements.size()) continue;
    for (const std::string& unit : one->elements[element]) live.units.emplace(one->part, unit);
  }
  return live;
}

void Submissions::keep(const std::vector<SlurmTask>& live) {
  std::erase_if(all_, [&](const Submission& one) {
    return std::none_of(live.begin(), live.end(),
                        [&](const SlurmTask& task) { return task.job == one.job; });
  });
}

}  // namespace ertbench
