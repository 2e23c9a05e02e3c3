#include "bench/run/builds.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"

namespace ertbench {
namespace {

void add_once(const BuildStamp& stamp, std::vector<BuildStamp>& stamps) {
  if (std::find(stamps.begin(), stamps.end(), stamp) == stamps.end()) stamps.push_back(stamp);
}

std::optional<BuildStamp> stamp_in(const nlohmann::json& record, const char* key) {
  return record.contains(key) ? build_stamp_from_json(record.at(key)) : std::nullopt;
}

}  // namespace

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
  const BuildStamp now = stamp_of_records(experiment.plugins);
  for (ResultRow& row : results.rows) {
    if (row.type == "truth" || row.type == "no-contact") row.build.scored = {now};
  }
}

}  // namespace ertbench
