#include "bench/check/baseline.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/record/provenance.h"
#include "core/json_text.h"
#include "core/quantile.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

json datasets_of(const Experiment& experiment) {
  json out = json::object();
  for (const DatasetSpec* spec : experiment.datasets()) out[spec->name] = to_json(*spec);
  return out;
}

/// What the row of this label is made from; the seed is not part of it, as any will do.
json entry_of(const Experiment& experiment, const std::string& label) {
  for (const SolverEntry& entry : experiment.solvers) {
    if (entry.label != label) continue;
    json out = *entry.spec;
    for (const char* key : {"label", "seed", "seeds"}) out.erase(key);
    return out;
  }
  return json::object();
}

BaselineRow of_one_run(const Experiment& experiment, const ResultRow& row,
                       std::optional<ImageComparison> images) {
  BaselineRow out;
  out.label = row.label;
  out.dataset = row.dataset;
  out.entry = entry_of(experiment, row.label);
  out.tolerance = tolerance_of(row, images);
  out.status = row.status;
  out.frames = row.frames;
  out.undefined_frames = row.undefined_frames;
  out.frames_not_converged = row.frames_not_converged;
  for (const Metric metric : kMetrics) {
    if (row.metrics[metric].mean) out.metrics[metric] = {*row.metrics[metric].mean};
  }
  out.times = relative_times(row);
  return out;
}

void add_seeds(const ResultRow& row, BaselineRow& out) {
  if (!row.seeds || row.seeds->values.size() < least_seeds) {
    throw std::invalid_argument("row " + row.label + ": its training seeds are too few");
  }
  out.seeds = row.seeds->values;
  for (const Metric metric : kMetrics) {
    out.metrics[metric].clear();
    const auto& means = row.seeds->means[metric];
    const bool all = std::all_of(means.begin(), means.end(), [](const auto& m) { return bool(m); });
    if (!all) continue;
    for (const auto& mean : means) out.metrics[metric].push_back(*mean);
  }
}

std::string shown(const json& value, const json::json_pointer& place) {
  return value.contains(place) ? json_shown(value.at(place)) : "absent";
}

/// The first difference, in the words of changed_experiment.
std::string first_difference(const json& before, const json& now, const std::string& place) {
  const json patch = json::diff(before, now);
  if (patch.empty()) return "";
  const std::string path = patch.front().at("path");
  const json::json_pointer pointer(path);
  return place + path + " was " + shown(before, pointer) + " and is " + shown(now, pointer);
}

}  // namespace

std::optional<RelativeTimes> relative_times(const ResultRow& row) {
  if (!row.latency_us || !row.frames_per_s || !row.calibration_us) return std::nullopt;
  if (!(*row.calibration_us > 0) || !(*row.frames_per_s > 0)) return std::nullopt;
  const std::vector<double>& rounds = row.latency_us->relative_of_rounds;
  return RelativeTimes{rounds.empty() ? row.latency_us->p50 / *row.calibration_us : median(rounds),
                       1e6 / *row.frames_per_s / *row.calibration_us};
}

BaselineMean mean_of(const BaselineRow& row, Metric metric, const Sensor& sensor) {
  const std::vector<double>& resolution = row.metrics[Metric::RES];
  return {metric, row.metrics[metric], row.frames, sensor,
          resolution.empty() ? std::nullopt : std::optional(centre_of(resolution))};
}

const BaselineRow* Baseline::find(const ResultRow& row) const {
  const auto found =
      std::find_if(rows.begin(), rows.end(), [&](const BaselineRow& one) { return one.is(row); });
  return found == rows.end() ? nullptr : &*found;
}

Comparisons comparisons_of(const Experiment& experiment, SolverRegistry& registry) {
  Comparisons out;
  for (const SolverEntry& entry : experiment.solvers) {
    const SolverInfo* info = registry.find(entry.type);
    out[entry.label] = info ? info->comparison : ImageComparison::rounding;
  }
  return out;
}

std::set<std::string> trained_labels(const Comparisons& comparisons) {
  std::set<std::string> labels;
  for (const auto& [label, images] : comparisons) {
    if (images == ImageComparison::seeds) labels.insert(label);
  }
  return labels;
}

Baseline make_baseline(const Experiment& experiment, std::span<const ResultRow> rows,
                       const Comparisons& comparisons) {
  Baseline baseline;
  baseline.experiment = experiment.name;
  json machine = machine_provenance();
  machine.erase("host");  // of no use in a file for all
  baseline.cpu = machine.at("cpu");
  baseline.provenance = std::move(machine);
  baseline.datasets = datasets_of(experiment);
  for (const ResultRow& row : rows) {
    const auto found = comparisons.find(row.label);
    const auto images = found == comparisons.end() ? std::nullopt : std::optional(found->second);
    baseline.rows.push_back(of_one_run(experiment, row, images));
    if (images == ImageComparison::seeds) add_seeds(row, baseline.rows.back());
  }
  return baseline;
}

std::string changed_experiment(const Baseline& baseline, const Experiment& experiment) {
  std::string change = first_difference(*baseline.datasets, datasets_of(experiment), "/datasets");
  if (!change.empty()) return change;
  for (const BaselineRow& row : baseline.rows) {
    const json now = entry_of(experiment, row.label);
    if (now.empty()) continue;  // removed: its row will be missing
    change = first_difference(*row.entry, now, "the entry of " + row.label + ", ");
    if (!change.empty()) return change;
  }
  return "";
}

}  // namespace ertbench
