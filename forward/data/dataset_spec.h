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
  /// What presses: contacts drawn at random or listed, touches of a skin at rest, or sequences of
  /// touches over time; or where the frames are that were measured.
  std::variant<SceneDistribution, std::vector<Scene>, TouchDistribution, SequenceSet,
               MeasuredFrames>
      scenes;

  /// Scene `index` < count, the noise on its frame and the draw of its faults depend on (seed,
  /// draws, index) alone. Not of sequences, whose frames follow from each other (SequenceFrames),
  /// and of measured frames, which are read (MeasuredBlocks).
  Scene scene(std::uint64_t index) const;
  RandomStream noise_stream(std::uint64_t index) const;
  RandomStream stream(std::uint64_t index, Purpose purpose) const;
  /// The number that frame `index` has the draw of its faults under: a sensor does not change
  /// within a sequence.
  std::uint64_t fault_number(std::uint64_t index) const;
  /// The scene that frame `index` shows, where several show the same.
  std::uint64_t scene_number(std::uint64_t index) const;

  /// The sequences; null where the scenes do not move.
  const SequenceSet* sequences() const { return std::get_if<SequenceSet>(&scenes); }
  /// Where the frames were measured; null where they are generated.
  const MeasuredFrames* measured() const { return std::get_if<MeasuredFrames>(&scenes); }
  bool has_touches() const {
    return sequences() || std::holds_alternative<TouchDistribution>(scenes);
  }

  std::size_t most_contacts() const;  ///< in one scene
  std::size_t most_vertices() const;  ///< in one contact, 0 where there are no polygons
};

/// Reads `{"count", "seed", "draws_of", "grid", "model_error", "rasterisation", "snr_db",
/// "snr_basis", "faults", "scenes"}`. "scenes" is a list of scenes, or an object: with "touches" a
/// TouchDistribution, with "sequence" a SequenceSet, else a SceneDistribution. Of a list, of
/// touches at places and of sequences "count" follows from them and may be left out.
///
/// With "file" in place of "scenes" the frames are read (measured_frames_from_json), and of the
/// other keys only "seed", "snr_db" and "snr_basis" are left: noise that trainings add.
/// `folder` is what a relative "file" begins at; without one the object is to_json's.
DatasetSpec dataset_spec_from_json(JsonObject object, const Sensor& sensor, const std::string& name,
                                   const std::optional<std::filesystem::path>& folder = {});

/// The canonical JSON with every default filled in, the sensor and the format version: what a
/// dataset's cache key is made of and what its file carries.
nlohmann::json to_json(const DatasetSpec& spec);

}  // namespace ertbench
