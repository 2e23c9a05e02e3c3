#include "bench/cluster/slurm_plan.h"

#include <algorithm>

#include "bench/run/job_records.h"
#include "bench/run/stages.h"

namespace ertbench {
namespace {

bool is_wanted(const SolverEntry& entry, const std::vector<std::string>& only) {
  return only.empty() || std::any_of(only.begin(), only.end(), [&](const std::string& label) {
           return label == entry.label || label == entry.family;
         });
}

/// So many units in each element that there are not too many elements.
std::vector<Units> elements_of(const Units& units, std::size_t most) {
  const std::size_t each = std::max<std::size_t>(1, (units.size() + most - 1) / most);
  std::vector<Units> elements;
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (i % each == 0) elements.emplace_back();
    elements.back().push_back(units[i]);
  }
  return elements;
}

class Planner {
 public:
  Planner(const Experiment& experiment, const Cache& cache, const LiveUnits& live,
          const SlurmPlanSettings& settings)
      : experiment_(experiment), cache_(cache), live_(live), settings_(settings) {}

  std::vector<SlurmPart> plan() {
    std::vector<SlurmPart> parts;
    for (const auto& stage : stages_of_run(Machines::any)) {
      const Units units = missing_units(*stage);
      if (units.empty()) continue;
      const bool alone = stage->wants_machine_alone();
      parts.push_back({stage->name(),
                       alone
                           ? elements_of_labels(*stage, units)
                           : elements_of(units, static_cast<std::size_t>(settings_.most_elements)),
                       alone});
    }
    if (!parts.empty()) {
      // An element for each, as the set for training may take a thousand times the others' time. It
      // makes sure, too, of those that are there.
      SlurmPart datasets{"datasets", {}, false};
      for (const DatasetSpec* spec : experiment_.datasets()) {
        if (!live_.has("datasets", spec->name)) datasets.elements.push_back({spec->name});
      }
      if (!datasets.elements.empty()) parts.insert(parts.begin(), std::move(datasets));
    }
    parts.push_back({"report", {{}}, false});
    return parts;
  }

 private:
  bool has_records(const JobRecords& records, const std::vector<Job>& jobs) const {
    return std::all_of(jobs.begin(), jobs.end(),
                       [&](const Job& job) { return static_cast<bool>(records.find(job).record); });
  }

  /// Entries of the stage of accuracy. Of the others, which take the first entry of a label that
  /// was scored, labels that no entry has all records for.
  Units missing_units(const Stage& stage) const {
    if (stage.name() == "timing" && !experiment_.timing.enabled) return {};
    if (stage.name() == "ladders" && !experiment_.ladders) return {};
    const bool by_entry = stage.name() == "accuracy";
    const JobRecords records(stage, experiment_, settings_.out, cache_.reuse());
    std::vector<std::pair<const SolverEntry*, std::vector<Job>>> jobs;
    for (const Job& job : stage.jobs(experiment_)) {
      if (!job.entry || !is_wanted(*job.entry, settings_.only)) continue;
      const auto found = std::find_if(jobs.begin(), jobs.end(),
                                      [&](const auto& one) { return one.first == job.entry; });
      (found == jobs.end() ? jobs.emplace_back(job.entry, std::vector<Job>()) : *found)
          .second.push_back(job);
    }
    Units units;
    std::set<std::string> complete;
    for (const auto& [entry, of_entry] : jobs) {
      const std::string unit = by_entry ? entry->stem() : entry->label;
      if (has_records(records, of_entry)) complete.insert(unit);
    }
    for (const auto& [entry, of_entry] : jobs) {
      const std::string unit = by_entry ? entry->stem() : entry->label;
      if (complete.count(unit) > 0 || live_.has(stage.name(), unit)) continue;
      if (units.empty() || units.back() != unit) units.push_back(unit);
    }
    return units;
  }

  /// Blocks of labels that are timed together, as far as one of them has something missing.
  std::vector<Units> elements_of_labels(const Stage& stage, const Units& missing) const {
    Units labels;
    for (const auto& row : experiment_.rows()) {
      if (is_wanted(row.front(), settings_.only) && !live_.has(stage.name(), row.front().label)) {
        labels.push_back(row.front().label);
      }
    }
    const std::size_t most = static_cast<std::size_t>(settings_.most_elements);
    const std::size_t blocks =
        std::min(most, (labels.size() + most_timed_together - 1) / most_timed_together);
    std::vector<Units> elements = elements_of(labels, std::max<std::size_t>(1, blocks));
    std::erase_if(elements, [&](const Units& block) {
      return std::none_of(block.begin(), block.end(), [&](const std::string& label) {
        return std::find(missing.begin(), missing.end(), label) != missing.end();
      });
    });
    return elements;
  }

  const Experiment& experiment_;
  const Cache& cache_;
  const LiveUnits& live_;
  const SlurmPlanSettings& settings_;
};

}  // namespace

std::vector<SlurmPart> slurm_plan(const Experiment& experiment, const Cache& cache,
                                  const LiveUnits& live, const SlurmPlanSettings& settings) {
  return Planner(experiment, cache, live, settings).plan();
}

Experiment restricted_to(const Experiment& experiment, const Units& units) {
  const std::set<std::string> names(units.begin(), units.end());
  Experiment out = experiment;
  std::erase_if(out.solvers, [&](const SolverEntry& entry) {
    return names.count(entry.label) == 0 && names.count(entry.stem()) == 0;
  });
  return out;
}

}  // namespace ertbench
