#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>

#include "bench/check/baseline.h"
#include "core/json_checksum.h"
#include "core/json_reader.h"
#include "core/json_text.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr int schema = 1;
constexpr int most = std::numeric_limits<int>::max();

json to_json(const BaselineRow& row, std::span<const Metric> known) {
  json metrics = json::object();
  for (const Metric metric : known) {
    const std::vector<double>& values = row.metrics[metric];
    json& out = metrics[name_of(metric)];
    if (!values.empty()) out = row.seeds.empty() ? json(values.front()) : json(values);
  }
  json out = {
      {"label", row.label},
      {"dataset", row.dataset},
      {"entry", *row.entry},
      {"tolerance", {{"class", name_of(row.tolerance.type)}, {"relative", row.tolerance.relative}}},
      {"status", row.status},
      {"frames", row.frames},
      {"undefined_frames", row.undefined_frames},
      {"frames_not_converged", row.frames_not_converged},
      {"metrics", std::move(metrics)},
      {"times", nullptr}};
  if (!row.seeds.empty()) out["seeds"] = row.seeds;
  if (row.times) {
    out["times"] = {{"latency", row.times->latency}, {"batch_frame", row.times->batch_frame}};
  }
  return out;
}

std::vector<double> values_from(JsonObject& metrics, const char* name, std::size_t seeds) {
  const json& value = metrics.raw(name);
  if (value.is_null()) return {};
  return seeds == 0 ? std::vector{metrics.number(name)} : metrics.numbers(name, seeds);
}

/// The metrics that some row has, if only as undefined.
std::vector<Metric> metrics_of(const std::vector<JsonObject>& rows) {
  std::vector<Metric> known;
  for (const Metric metric : kMetrics) {
    const bool has = std::any_of(rows.begin(), rows.end(), [&](const JsonObject& row) {
      return row.value().contains(json::json_pointer(std::string("/metrics/") + name_of(metric)));
    });
    if (has) known.push_back(metric);
  }
  return known;
}

BaselineRow row_from(JsonObject object, std::span<const Metric> known) {
  BaselineRow row;
  row.label = object.text("label");
  row.dataset = object.text("dataset");
  row.entry = object.object("entry").value();
  JsonObject tolerance = object.object("tolerance");
  row.tolerance.type =
      tolerance_class_from_name(tolerance.choice("class", tolerance_class_names()));
  row.tolerance.relative = tolerance.number("relative", {0, 1});
  tolerance.finish();
  row.status = object.text("status");
  row.frames = object.integer("frames", 0, most);
  row.undefined_frames = object.integer("undefined_frames", 0, most);
  row.frames_not_converged = object.integer("frames_not_converged", 0, most);
  if (object.has("seeds")) row.seeds = object.integers("seeds", least_seeds, 1000, {0, most});
  JsonObject metrics = object.object("metrics");
  for (const Metric metric : known) {
    row.metrics[metric] = values_from(metrics, name_of(metric), row.seeds.size());
  }
  metrics.finish();
  const bool scored = row.frames > row.undefined_frames;
  if (scored && std::all_of(known.begin(), known.end(),
                            [&](Metric metric) { return row.metrics[metric].empty(); })) {
    object.fail("metrics",
                "has no value, though " + std::to_string(row.frames) + " frames were scored");
  }
  if (!object.raw("times").is_null()) {
    JsonObject times = object.object("times");
    row.times = RelativeTimes{times.number("latency", Range::positive()),
                              times.number("batch_frame", Range::positive())};
    times.finish();
  }
  object.finish();
  return row;
}

std::vector<std::string> names_from(JsonObject& root, const char* key) {
  const json& names = root.raw(key);
  if (!names.is_array() ||
      !std::all_of(names.begin(), names.end(), [](const json& name) { return name.is_string(); })) {
    root.fail(key, "must be a list of names, got " + json_shown(names));
  }
  return names.get<std::vector<std::string>>();
}

}  // namespace

std::string to_json_text(const Baseline& baseline) {
  json out = {{"schema", schema},
              {"experiment", baseline.experiment},
              {"provenance", *baseline.provenance},
              {"datasets", *baseline.datasets},
              {"rows", json::array()}};
  for (const BaselineRow& row : baseline.rows)
    out["rows"].push_back(to_json(row, baseline.metrics));
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
  for (const JsonObject& row : rows) baseline.rows.push_back(row_from(row, baseline.metrics));
  baseline.networks = names_from(root, "networks");
  baseline.trainings = names_from(root, "trainings");
  if (!changed.empty()) root.fail("checksum", "is not that of the content: " + changed);
  root.finish();
  return baseline;
}

}  // namespace ertbench
