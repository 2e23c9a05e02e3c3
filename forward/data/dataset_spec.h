#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "forward/data/faults.h"
#include "forward/data/measured_frames.h"
#include "forward/data/scene_distribution.h"
#include "forward/data/sheet_model.h"
#include "forward/sheet/rasterise.h"
#include "forward/sheet/sensor.h"
#include "forward/touch/touch_distribution.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {

/// Everything that determines a dataset file: equal specs give equal files.
struct DatasetSpec {
  /// Raised when the same spec gives other numbers or another layout.
  static constexpr int format_version = 1;

  Sensor sensor;
  std::string name;
  /// The set whose random numbers this one draws; empty for its own. Sets with different names
  /// otherwise have different scenes.
  std::string draws;
  std::uint64_t seed = 1;
  std::uint64_t count = 0;  ///< scenes
  SheetModel model;         ///< model of the voltages; the truth is always an image_grid image
  Rasterisation rasterisation = Rasterisation::area;
  Noise noise;
  Faults faults;
  /// The scenes: random or listed contacts, touches of a skin at rest, sequences of touches over
  /// time, or frames that were measured.
  std::variant<SceneDistribution, std::vector<Scene>, TouchDistribution, SequenceSet,
               MeasuredFrames>
      scenes;

  /// Scene `index` < count. The scene, the noise on its frame and its faults depend only on (seed,
  /// draws, index). Throws std::logic_error for sequences, whose frames depend on each other
  /// (SequenceFrames), and for measured frames, which are read (MeasuredBlocks).
  Scene scene(std::uint64_t index) const;
  RandomStream noise_stream(std::uint64_t index) const;
  RandomStream stream(std::uint64_t index, Purpose purpose) const;
  /// The index under which the faults of frame `index` are drawn: a sensor does not change within a
  /// sequence.
  std::uint64_t fault_number(std::uint64_t index) const;
  /// The scene of frame `index`; several frames may show the same scene.
  std::uint64_t scene_number(std::uint64_t index) const;

  /// Null for scenes that do not move.
  const SequenceSet* sequences() const { return std::get_if<SequenceSet>(&scenes); }
  /// Null for generated frames.
  const MeasuredFrames* measured() const { return std::get_if<MeasuredFrames>(&scenes); }
  bool has_touches() const {
    return sequences() || std::holds_alternative<TouchDistribution>(scenes);
  }

  std::size_t most_contacts() const;  ///< in one scene
  std::size_t most_vertices() const;  ///< of one contact, 0 without polygons
};

/// Reads `{"count", "seed", "draws_of", "grid", "model_error", "rasterisation", "snr_db",
/// "snr_basis", "faults", "scenes"}`. "scenes" is a list of scenes, or an object: with "touches" a
/// TouchDistribution, with "sequence" a SequenceSet, else a SceneDistribution. "count" may be left
/// out for a list, for touches at places and for sequences, from which it follows.
///
/// With "file" in place of "scenes" the frames are read (measured_frames_from_json); the only other
/// keys are "seed", "snr_db" and "snr_basis", of noise that trainings add. A relative "file" starts
/// from `folder`; without a folder the object is one written by to_json.
DatasetSpec dataset_spec_from_json(JsonObject object, const Sensor& sensor, const std::string& name,
                                   const std::optional<std::filesystem::path>& folder = {});

/// The canonical JSON with all defaults, the sensor and the format version. It is hashed into the
/// dataset's cache key and stored in its file.
nlohmann::json to_json(const DatasetSpec& spec);

}  // namespace ertbench
