#include "bench/check/baseline.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/record/record_file.h"
#include "core/checksum.h"
#include "core/fields.h"
#include "core/json.h"
#include "core/statistics.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

json datasets_of(const Experiment& experiment) {
  json out = json::object();
  for (const DatasetSpec* spec : experiment.datasets()) out[spec->name] = to_json(*spec);
  return out;
}

/// The entry that the row of this label is made from, without the seed.
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
    const bool all = std::ranges::all_of(means, [](const auto& m) { return bool(m); });
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

constexpr int schema = 1;
constexpr int most = std::numeric_limits<int>::max();

/// The values of one metric: a number, or one for each of the row's seeds; null without any.
void visit(Fields& fields, const char* key, std::vector<double>& values, std::size_t seeds) {
  fields.required().nullable();
  if (seeds == 0 || (fields.writing() && values.empty())) {
    std::optional<double> value;
    if (!values.empty()) value = values.front();
    fields.number(key, value, {});
    if (value) values = {*value};
    return;
  }
  std::vector<double> list = values;
  list.resize(seeds, std::nan(""));  // which stays where there is null
  fields.numbers(key, list, {});
  if (!std::isnan(list.front())) values = list;
}

/// `known`: the metrics that the baseline has.
void visit(Fields& fields, BaselineRow& row, std::span<const Metric> known) {
  fields.required().text("label", row.label);
  fields.required().text("dataset", row.dataset);
  fields.required().any("entry", row.entry);
  if (!row.entry->is_object()) {
    fields.fail("entry", "must be an object, got " + json_shown(*row.entry));
  }
  fields.required().object("tolerance", [&](Fields& tolerance) {
    tolerance.required().choice("class", row.tolerance.type,
                                {{"exact", ToleranceClass::exact},
                                 {"linear", ToleranceClass::linear},
                                 {"interior point", ToleranceClass::interior_point},
                                 {"seeds", ToleranceClass::seeds}});
    tolerance.required().number("relative", row.tolerance.relative, {0, 1});
  });
  fields.required().text("status", row.status);
  fields.required().integer("frames", row.frames, 0, most);
  fields.required().integer("undefined_frames", row.undefined_frames, 0, most);
  fields.required().integer("frames_not_converged", row.frames_not_converged, 0, most);
  if (fields.reading() || !row.seeds.empty()) {
    fields.integers("seeds", row.seeds, least_seeds, 1000, {0, most});
  }
  fields.required().object("metrics", [&](Fields& metrics) {
    for (const Metric metric : known) {
      const char* key = key_in_file(metric, [&](const char* k) { return metrics.has(k); });
      visit(metrics, key ? key : name_of(metric), row.metrics[metric], row.seeds.size());
    }
  });
  const bool scored = row.frames > row.undefined_frames;
  if (fields.reading() && scored &&
      std::ranges::all_of(known, [&](Metric metric) { return row.metrics[metric].empty(); })) {
    fields.fail("metrics",
                "has no value, though " + std::to_string(row.frames) + " frames were scored");
  }
  fields.required().nullable().object("times", row.times, [](Fields& times, RelativeTimes& of_row) {
    times.required().number("latency", of_row.latency, Range::positive());
    times.required().number("batch_frame", of_row.batch_frame, Range::positive());
  });
}

/// The metrics that some row has, if only as undefined.
std::vector<Metric> metrics_of(const std::vector<JsonObject>& rows) {
  std::vector<Metric> known;
  for (const Metric metric : kMetrics) {
    const bool has = std::ranges::any_of(rows, [&](const JsonObject& row) {
      const json metrics = row.value().value("metrics", json::object());
      return key_in_file(metric, [&](const char* k) { return metrics.contains(k); }) != nullptr;
    });
    if (has) known.push_back(metric);
  }
  return known;
}

std::vector<std::string> names_from(JsonObject& root, const char* key) {
  const json& names = root.raw(key);
  if (!names.is_array() ||
      !std::ranges::all_of(names, [](const json& name) { return name.is_string(); })) {
    root.fail(key, "must be a list of names, got " + json_shown(names));
  }
  return names.get<std::vector<std::string>>();
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
  const auto found = std::ranges::find_if(rows, [&](const BaselineRow& one) {
    return one.label == row.label && one.dataset == row.dataset;
  });
  return found == rows.end() ? nullptr : &*found;
}

Comparisons comparisons_of(const Experiment& experiment, SolverRegistry& registry) {
  Comparisons out;
  for (const SolverEntry& entry : experiment.solvers) {
    const SolverInfo* info = registry.find(entry.type);
    // A stored solver is trained by no check.
    const bool trained = info && !entry.spec->contains("checkpoint");
    out[entry.label] = trained ? info->comparison : ImageComparison::rounding;
  }
  return out;
}

Baseline make_baseline(const Experiment& experiment, std::span<const ResultRow> rows,
                       const Comparisons& comparisons) {
  Baseline baseline;
  baseline.experiment = experiment.name;
  json machine = machine_provenance();
  machine.erase("host");  // meaningless elsewhere
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

std::string to_json_text(const Baseline& baseline) {
  json out = {{"schema", schema},
              {"experiment", baseline.experiment},
              {"provenance", *baseline.provenance},
              {"datasets", *baseline.datasets},
              {"rows", json::array()}};
  for (BaselineRow row : baseline.rows) {
    out["rows"].push_back(
        Fields::written([&](Fields& fields) { visit(fields, row, baseline.metrics); }));
  }
  out["networks"] = baseline.networks;
  out["trainings"] = baseline.trainings;
  add_checksum(out);
  return json_text(out, 2) + "\n";
}

Baseline read_baseline(const std::filesystem::path& file) {
  json value = read_json_file(file);
  const std::string changed = take_checksum(value);
  JsonObject root(value, file.string(), "");
  if (const int found = root.integer("schema", 0, most); found != schema) {
    root.fail("schema", "is " + std::to_string(found) + ", this program reads " +
                            std::to_string(schema) + "; make the baseline anew with --update");
  }
  Baseline baseline;
  baseline.experiment = root.text("experiment");
  JsonObject provenance = root.object("provenance");
  baseline.cpu = provenance.text("cpu");
  baseline.provenance = provenance.value();
  baseline.datasets = root.object("datasets").value();
  const std::vector<JsonObject> rows = root.objects("rows");
  baseline.metrics = metrics_of(rows);
  if (rows.empty()) root.fail("rows", "holds no rows, with which nothing could be compared");
  for (const JsonObject& row : rows) {
    Fields::read(row, [&, &of_row = baseline.rows.emplace_back()](Fields& fields) {
      visit(fields, of_row, baseline.metrics);
    });
  }
  baseline.networks = names_from(root, "networks");
  baseline.trainings = names_from(root, "trainings");
  if (!changed.empty()) root.fail("checksum", "is not that of the content: " + changed);
  root.finish();
  return baseline;
}

}  // namespace ertbench
