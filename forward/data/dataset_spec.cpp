#include "forward/data/dataset_spec.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json_reader.h"

namespace ertbench {

Scene DatasetSpec::scene(std::uint64_t index) const {
  if (const auto* list = std::get_if<std::vector<Scene>>(&scenes)) return (*list)[index];
  RandomStream random(seed, key_of(draws.empty() ? name : draws), index, Purpose::scene);
  return std::get<SceneDistribution>(scenes).draw(random, *sensor.sheet);
}

RandomStream DatasetSpec::noise_stream(std::uint64_t index) const {
  return stream(index, Purpose::noise);
}

RandomStream DatasetSpec::stream(std::uint64_t index, Purpose purpose) const {
  return RandomStream(seed, key_of(draws.empty() ? name : draws), index, purpose);
}

std::size_t DatasetSpec::most_contacts() const {
  if (const auto* d = std::get_if<SceneDistribution>(&scenes)) {
    return static_cast<std::size_t>(d->contacts.second);
  }
  std::size_t most = 0;
  for (const Scene& s : std::get<std::vector<Scene>>(scenes)) {
    most = std::max(most, s.contacts.size());
  }
  return most;
}

std::size_t DatasetSpec::most_vertices() const {
  if (const auto* d = std::get_if<SceneDistribution>(&scenes)) {
    return d->most_vertices();
  }
  std::size_t most = 0;
  for (const Scene& s : std::get<std::vector<Scene>>(scenes)) {
    for (const Contact& c : s.contacts) most = std::max(most, c.vertices.size());
  }
  return most;
}

namespace {

/// Reads "grid" and "model_error".
SheetModel sheet_model_from_json(JsonObject& object, const Sensor& sensor) {
  if (object.has("grid") && object.raw("grid").is_string()) {
    object.choice("grid", {"auto"});
    ContinuousSheet sheet;
    sheet.model_error = object.number_or("model_error", sheet.model_error, {1e-6, 10});
    return sheet;
  }
  if (object.has("model_error")) {
    object.fail("model_error", R"(needs "grid": "auto"; a grid's error is what it is)");
  }
  const int side = object.integer_or("grid", sensor.image_grid, 1, 1536);
  int refined = sensor.image_grid;
  while (refined < side) refined *= 2;
  if (refined != side) {
    object.fail("grid", "must be the image grid times a power of two (" +
                            std::to_string(sensor.image_grid) + ", " +
                            std::to_string(2 * sensor.image_grid) + ", " +
                            std::to_string(4 * sensor.image_grid) + ", ...) or \"auto\", got " +
                            std::to_string(side));
  }
  return GridSheet{side};
}

}  // namespace

DatasetSpec dataset_spec_from_json(JsonObject object, const Sensor& sensor,
                                   const std::string& name) {
  DatasetSpec spec;
  spec.sensor = sensor;
  spec.name = name;
  if (object.has("draws_of")) spec.draws = object.text("draws_of");
  spec.seed = static_cast<std::uint64_t>(object.integer_or("seed", 1, 0, 2147483647));
  const nlohmann::json& scenes = object.raw("scenes");
  if (scenes.is_array()) {
    if (scenes.empty()) object.fail("scenes", "must hold at least one scene");
    std::vector<Scene> list;
    for (const JsonObject& scene : object.objects("scenes")) {
      list.push_back(scene_from_json(scene, *sensor.sheet));
    }
    spec.count = list.size();
    if (object.has("count") &&
        object.integer("count", 1, 1000000000) != static_cast<int>(list.size())) {
      object.fail("count", "must be left out or equal the number of scenes listed, " +
                               std::to_string(list.size()));
    }
    spec.scenes = std::move(list);
  } else {
    spec.scenes = scene_distribution_from_json(object.object("scenes"), *sensor.sheet);
    spec.count = static_cast<std::uint64_t>(object.integer("count", 1, 1000000000));
  }

  spec.model = sheet_model_from_json(object, sensor);
  spec.rasterisation = object.choice_or("rasterisation", "area", {"area", "centre"}) == "area"
                           ? Rasterisation::area
                           : Rasterisation::centre;
  const nlohmann::json& snr = object.raw("snr_db");
  if (!snr.is_null()) {
    if (!snr.is_number()) object.fail("snr_db", "must be a number of dB, or null for no noise");
    spec.noise.snr_db = object.number("snr_db", {-200, 400, false, "dB"});
    spec.noise.basis = object.choice("snr_basis", {"absolute", "difference"}) == "absolute"
                           ? SnrBasis::absolute
                           : SnrBasis::difference;
  } else if (object.has("snr_basis")) {
    object.choice("snr_basis", {"absolute", "difference"});
  }
  if (object.has("faults")) {
    spec.faults = faults_from_json(object.object("faults"), sensor, spec.model);
  }
  object.finish();
  return spec;
}

nlohmann::json to_json(const DatasetSpec& spec) {
  nlohmann::json json = {{"format_version", DatasetSpec::format_version},
                         {"sensor", to_json(spec.sensor)},
                         {"name", spec.name},
                         {"seed", spec.seed},
                         {"count", spec.count},
                         {"grid", "auto"},
                         {"rasterisation", name_of(spec.rasterisation)},
                         {"snr_db", nullptr},
                         {"snr_basis", name_of(spec.noise.basis)}};
  if (spec.noise.snr_db) json["snr_db"] = *spec.noise.snr_db;
  if (const auto* grid = std::get_if<GridSheet>(&spec.model)) {
    json["grid"] = grid->side;
  } else {
    json["model_error"] = std::get<ContinuousSheet>(spec.model).model_error;
  }
  if (!spec.draws.empty()) json["draws_of"] = spec.draws;
  if (spec.faults.any()) json["faults"] = to_json(spec.faults);
  if (const auto* d = std::get_if<SceneDistribution>(&spec.scenes)) {
    json["scenes"] = to_json(*d);
  } else {
    for (const Scene& s : std::get<std::vector<Scene>>(spec.scenes)) {
      json["scenes"].push_back(to_json(s));
    }
  }
  return json;
}

}  // namespace ertbench
