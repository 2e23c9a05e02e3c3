#include "bench/fidelity/fidelity_record.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/record/cache.h"
#include "bench/record/record_file.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Raised whenever scenes are measured differently, or the layout changes.
constexpr int fidelity_schema = 1;

const char* const models[] = {"auto", "24", "48", "96", "192"};  ///< in the order of the table

double ratio_from(const json& value) {
  // Frames without noise have an infinite error, which JSON cannot express.
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

json scenes_json(const std::vector<ModelledScene>& scenes) {
  json out = json::object();
  for (const ModelledScene& scene : scenes) {
    out["smooth"].push_back(scene.smooth);
    out["time_us"].push_back(scene.time_us);
    out["error"].push_back(scene.error);
    out["estimate"].push_back(scene.estimate);
    out["points"].push_back(scene.points);
  }
  return out;
}

std::vector<ModelledScene> scenes_from(const json& object) {
  std::vector<ModelledScene> scenes(object.at("smooth").size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].smooth = object.at("smooth").at(i).get<bool>();
    scenes[i].time_us = object.at("time_us").at(i).get<double>();
    scenes[i].error = ratio_from(object.at("error").at(i));
    scenes[i].estimate = ratio_from(object.at("estimate").at(i));
    scenes[i].points = object.at("points").at(i).get<int>();
  }
  return scenes;
}

/// Fills in the estimates of "auto" and the sizes of its systems.
void add_promises(const std::vector<ModelledScene>& scenes, FidelityRow& row) {
  std::vector<double> ratios;
  row.sizes.resize(std::size(fidelity_sizes) + 1);
  for (const ModelledScene& scene : scenes) {
    const bool promised = scene.estimate <= row.bound;
    row.promised += promised;
    row.promised_kept += promised && scene.error <= row.bound;
    if (scene.error > 0) ratios.push_back(scene.estimate / scene.error);
    const auto size =
        std::lower_bound(std::begin(fidelity_sizes), std::end(fidelity_sizes), scene.points);
    ++row.sizes[static_cast<std::size_t>(size - std::begin(fidelity_sizes))];
  }
  if (!ratios.empty()) row.tightness = median(ratios);
}

FidelityRow row_of(const DatasetSpec& dataset, const std::string& kind, const std::string& model,
                   const std::vector<ModelledScene>& scenes) {
  FidelityRow row;
  row.dataset = dataset.name;
  row.scenes = kind;
  row.model = model;
  row.count = static_cast<int>(scenes.size());
  row.bound = model_error_of(dataset.model);
  std::vector<double> times;
  std::vector<double> errors;
  for (const ModelledScene& scene : scenes) {
    times.push_back(scene.time_us);
    errors.push_back(scene.error);
    row.kept += scene.error <= row.bound;
  }
  const SortedValues sorted_times = times;
  row.time_us = median(sorted_times);
  row.time_low = interpolated_quantile(sorted_times, 0.05);
  row.time_high = interpolated_quantile(sorted_times, 0.95);
  const SortedValues sorted_errors = errors;
  row.error_median = median(sorted_errors);
  row.error_p95 = interpolated_quantile(sorted_errors, 0.95);
  row.error_max = sorted_errors.largest();
  if (model == "auto") add_promises(scenes, row);
  return row;
}

std::vector<ModelledScene> of_kind(const std::vector<ModelledScene>& scenes, bool smooth) {
  std::vector<ModelledScene> out;
  std::copy_if(scenes.begin(), scenes.end(), std::back_inserter(out),
               [&](const ModelledScene& scene) { return scene.smooth == smooth; });
  return out;
}

}  // namespace

int fidelity_scenes(const DatasetSpec& dataset, int scenes) {
  return static_cast<int>(
      std::min<std::uint64_t>(dataset.count, static_cast<std::uint64_t>(scenes)));
}

std::string fidelity_key(const DatasetSpec& dataset, int scenes) {
  const json key = {{"schema", fidelity_schema},
                    {"dataset", to_json(dataset)},
                    {"scenes", fidelity_scenes(dataset, scenes)},
                    {"block", fidelity_block},
                    {"cpu", cpu_name()}};
  return hash_of(key.dump());
}

json to_json(const FidelityRecord& record) {
  json out = {{"schema", fidelity_schema}, {"models", json::object()}};
  for (const auto& [model, scenes] : record.models) out["models"][model] = scenes_json(scenes);
  return out;
}

FidelityRecord fidelity_record_from_json(const json& record) {
  FidelityRecord out;
  for (const auto& [model, scenes] : record.at("models").items()) {
    out.models[model] = scenes_from(scenes);
  }
  return out;
}

std::vector<FidelityRow> fidelity_rows(const DatasetSpec& dataset, const FidelityRecord& record) {
  std::vector<FidelityRow> parts;
  std::vector<FidelityRow> all;
  bool mixed = true;
  for (const bool smooth : {true, false}) {
    for (const char* model : models) {
      const auto found = record.models.find(model);
      if (found == record.models.end()) continue;
      const std::vector<ModelledScene> some = of_kind(found->second, smooth);
      mixed = mixed && !some.empty();
      if (!some.empty()) {
        parts.push_back(row_of(dataset, smooth ? "smooth" : "other", model, some));
      }
      if (smooth) all.push_back(row_of(dataset, "all", model, found->second));
    }
  }
  if (!mixed) return all;
  parts.insert(parts.end(), all.begin(), all.end());
  return parts;
}

}  // namespace ertbench
