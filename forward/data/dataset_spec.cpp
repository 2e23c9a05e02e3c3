#include "forward/data/dataset_spec.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/json.h"
#include "forward/touch/indenter.h"

namespace ertbench {

namespace {

/// Calls the function that suits what the scenes are.
template <typename... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <typename... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

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
  // Where the grid cannot serve, the continuous sheet does.
  if (!object.has("grid") && !fits_grid(sensor, sensor.image_grid)) return ContinuousSheet{};
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
  if (!fits_grid(sensor, side)) {
    object.fail("grid", "does not serve this sensor (a " + sensor.sheet->name() +
                            "): it is for squares and rectangles in square pixels with point "
                            R"(electrodes on its nodes; leave it out or use "auto")");
  }
  return GridSheet{side};
}

std::uint64_t read_count(JsonObject& object) {
  return static_cast<std::uint64_t>(object.integer("count", 1, 1000000000));
}

/// Reads "count" of scenes of which it is known: it may be left out.
void require_count(JsonObject& object, std::uint64_t count, const char* what) {
  if (object.has("count") && read_count(object) != count) {
    object.fail("count", "must be left out or equal the number of " + std::string(what) + ", " +
                             std::to_string(count));
  }
}

/// Reads "scenes" that are an object, and "count".
void read_drawn_scenes(JsonObject& object, DatasetSpec& spec) {
  const JsonObject scenes = object.object("scenes");
  if (scenes.has("sequence")) {
    SequenceSet set = sequence_set_from_json(scenes, spec.sensor);
    spec.count = set.frames();
    require_count(object, spec.count, "the sequences' frames");
    spec.scenes = std::move(set);
    return;
  }
  if (scenes.has("touches")) {
    TouchDistribution touches = touch_distribution_from_json(scenes, spec.sensor);
    if (touches.places) {
      spec.count = static_cast<std::uint64_t>(touches.places->count()) *
                   static_cast<std::uint64_t>(touches.draws);
    }
    if (!touches.places || object.has("count")) spec.count = read_count(object);
    spec.scenes = std::move(touches);
    return;
  }
  spec.scenes = scene_distribution_from_json(scenes, *spec.sensor.sheet);
  spec.count = read_count(object);
}

/// Reads "snr_db", "snr_basis" and "noise_spread".
void read_noise(JsonObject& object, Noise& noise) {
  const nlohmann::json& snr = object.raw("snr_db");
  if (!snr.is_null()) {
    if (!snr.is_number()) object.fail("snr_db", "must be a number of dB, or null for no noise");
    noise.snr_db = object.number("snr_db", {-200, 400, false, "dB"});
    noise.basis = object.choice("snr_basis", {"absolute", "difference"}) == "absolute"
                      ? SnrBasis::absolute
                      : SnrBasis::difference;
    noise.spread = object.number_or("noise_spread", 0, {0, 3});
  } else if (object.has("snr_basis")) {
    object.choice("snr_basis", {"absolute", "difference"});
  }
}

/// Reads what is left of the keys where frames are read from a file.
void read_measured(JsonObject& object, const std::optional<std::filesystem::path>& folder,
                   DatasetSpec& spec) {
  if (object.has("scenes")) {
    object.fail("scenes", "must be left out where the frames come from a \"file\"");
  }
  MeasuredFrames frames = measured_frames_from_json(object, spec.sensor, folder);
  spec.count = frames.rows().size();
  require_count(object, spec.count, "rows");
  spec.scenes = std::move(frames);
  if (object.has("snr_db")) read_noise(object, spec.noise);
}

}  // namespace

Scene DatasetSpec::scene(std::uint64_t index) const {
  RandomStream random = stream(scene_number(index), Purpose::scene);
  return std::visit(
      Overloaded{[&](const std::vector<Scene>& list) { return list[index]; },
                 [&](const SceneDistribution& d) { return d.draw(random, *sensor.sheet); },
                 [&](const TouchDistribution& d) {
                   return still_scene(sensor, d.draw(index, random, sensor));
                 },
                 [](const SequenceSet&) -> Scene {
                   throw std::logic_error("frames of a sequence follow from each other");
                 },
                 [](const MeasuredFrames&) -> Scene {
                   throw std::logic_error("measured frames are read, not drawn");
                 }},
      scenes);
}

RandomStream DatasetSpec::noise_stream(std::uint64_t index) const {
  return stream(index, Purpose::noise);
}

RandomStream DatasetSpec::stream(std::uint64_t index, Purpose purpose) const {
  return RandomStream(seed, key_of(draws.empty() ? name : draws), index, purpose);
}

std::uint64_t DatasetSpec::fault_number(std::uint64_t index) const {
  return sequences() ? sequences()->sequence_of(index) : index;
}

std::uint64_t DatasetSpec::scene_number(std::uint64_t index) const {
  const auto* touches = std::get_if<TouchDistribution>(&scenes);
  return touches ? touches->scene_of(index) : index;
}

std::size_t DatasetSpec::most_contacts() const {
  return std::visit(
      Overloaded{
          [](const std::vector<Scene>& list) {
            std::size_t most = 0;
            for (const Scene& s : list) most = std::max(most, s.contacts.size());
            return most;
          },
          [](const SceneDistribution& d) { return static_cast<std::size_t>(d.contacts.second); },
          [](const TouchDistribution& d) { return static_cast<std::size_t>(d.touches.second); },
          [](const SequenceSet& set) { return set.most_touches(); },
          [](const MeasuredFrames& frames) { return static_cast<std::size_t>(frames.contacts); }},
      scenes);
}

std::size_t DatasetSpec::most_vertices() const {
  const auto of_indenter = [](const Indenter& indenter) {
    const auto* face = std::get_if<FlatFace>(&indenter.body);
    return face ? face->vertices_mm.size() : 0;
  };
  std::size_t most = 0;
  std::visit(Overloaded{[&](const std::vector<Scene>& list) {
                          for (const Scene& s : list) {
                            for (const Contact& c : s.contacts) {
                              most = std::max(most, c.vertices.size());
                            }
                          }
                        },
                        [&](const SceneDistribution& d) { most = d.most_vertices(); },
                        [&](const TouchDistribution& d) {
                          for (const Indenter& indenter : d.indenters) {
                            most = std::max(most, of_indenter(indenter));
                          }
                        },
                        [&](const SequenceSet& set) {
                          std::visit([&](const auto& plan) { most = of_indenter(plan.indenter); },
                                     set.plan());
                        },
                        [](const MeasuredFrames&) {}},
             scenes);
  return most;
}

DatasetSpec dataset_spec_from_json(JsonObject object, const Sensor& sensor, const std::string& name,
                                   const std::optional<std::filesystem::path>& folder) {
  DatasetSpec spec;
  spec.sensor = sensor;
  spec.name = name;
  if (object.has("draws_of")) spec.draws = object.text("draws_of");
  spec.seed = static_cast<std::uint64_t>(object.integer_or("seed", 1, 0, 2147483647));
  if (object.has("file")) {
    read_measured(object, folder, spec);
    object.finish();
    return spec;
  }
  const nlohmann::json& scenes = object.raw("scenes");
  if (scenes.is_array()) {
    if (scenes.empty()) object.fail("scenes", "must hold at least one scene");
    std::vector<Scene> list;
    for (const JsonObject& scene : object.objects("scenes")) {
      list.push_back(scene_from_json(scene, *sensor.sheet));
    }
    spec.count = list.size();
    require_count(object, spec.count, "scenes listed");
    spec.scenes = std::move(list);
  } else {
    read_drawn_scenes(object, spec);
  }

  spec.model = sheet_model_from_json(object, sensor);
  if (spec.has_touches() && std::holds_alternative<ContinuousSheet>(spec.model)) {
    object.fail("grid",
                "must be a number, such as 96, for touches of a skin: its patches have "
                "borders everywhere");
  }
  spec.rasterisation = object.choice_or("rasterisation", "area", {"area", "centre"}) == "area"
                           ? Rasterisation::area
                           : Rasterisation::centre;
  read_noise(object, spec.noise);
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
                         {"count", spec.count}};
  if (!spec.draws.empty()) json["draws_of"] = spec.draws;
  const MeasuredFrames* const measured = spec.measured();
  if (spec.noise.snr_db || !measured) json["snr_basis"] = name_of(spec.noise.basis);
  if (spec.noise.snr_db) json["snr_db"] = *spec.noise.snr_db;
  if (measured) {
    add_to(json, *measured);
    return json;
  }
  if (!spec.noise.snr_db) json["snr_db"] = nullptr;
  if (spec.noise.spread > 0) json["noise_spread"] = spec.noise.spread;
  json["rasterisation"] = name_of(spec.rasterisation);
  if (const auto* grid = std::get_if<GridSheet>(&spec.model)) {
    json["grid"] = grid->side;
  } else {
    json["grid"] = "auto";
    json["model_error"] = std::get<ContinuousSheet>(spec.model).model_error;
  }
  if (spec.faults.any()) json["faults"] = to_json(spec.faults);
  json["scenes"] = std::visit(Overloaded{[](const std::vector<Scene>& list) {
                                           nlohmann::json scenes;
                                           for (const Scene& s : list) scenes.push_back(to_json(s));
                                           return scenes;
                                         },
                                         [](const MeasuredFrames&) { return nlohmann::json(); },
                                         [](const auto& drawn) { return to_json(drawn); }},
                              spec.scenes);
  return json;
}

}  // namespace ertbench
