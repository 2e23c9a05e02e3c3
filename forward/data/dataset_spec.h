#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <variant>
#include <vector>

#include "forward/data/faults.h"
#include "forward/data/noise.h"
#include "forward/data/scene_distribution.h"
#include "forward/data/sheet_model.h"
#include "forward/sheet/rasterise.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Everything that determines a dataset file. Two equal specs make equal files.
struct DatasetSpec {
  /// Raised whenever the same spec would give other numbers or another layout.
  static constexpr int format_version = 1;

  Sensor sensor;
  std::string name;
  /// The set whose random numbers this one draws, where it is another: sets of other names hold
  /// other scenes else.
  std::string draws;
  std::uint64_t seed = 1;
  std::uint64_t count = 0;  ///< scenes
  SheetModel model;         ///< of the voltages; the truth is always an image_grid image
  Rasterisation rasterisation = Rasterisation::area;
  Noise noise;
  Faults faults;
  std::variant<SceneDistribution, std::vector<Scene>> scenes;

  /// Scene `index` < count, the noise on its frame and the draw of its faults depend on (seed,
  /// draws, index) alone.
  Scene scene(std::uint64_t index) const;
  RandomStream noise_stream(std::uint64_t index) const;
  RandomStream stream(std::uint64_t index, Purpose purpose) const;

  std::size_t most_contacts() const;  ///< in one scene
  std::size_t most_vertices() const;  ///< in one contact, 0 where there are no polygons
};

/// Reads `{"count", "seed", "draws_of", "grid", "model_error", "rasterisation", "snr_db",
/// "snr_basis", "faults", "scenes"}`. "scenes" is a distribution (an object) or a list of scenes;
/// of a list "count" is the length.
DatasetSpec dataset_spec_from_json(JsonObject object, const Sensor& sensor,
                                   const std::string& name);

/// The canonical JSON with every default filled in, the sensor and the format version: what a
/// dataset's cache key is made of and what its file carries.
nlohmann::json to_json(const DatasetSpec& spec);

}  // namespace ertbench
