#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/json.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What is known of the frames of a set beside their voltages. Of generated sets both are.
struct Truth {
  bool images = true;  ///< the conductivity of every pixel, not only that of a declared contact
  bool places = true;  ///< where contacts are

  bool operator==(const Truth&) const = default;
};

/// A part of rows that were shuffled: for cross-validation, and for training on fewer.
struct FoldPart {
  int count = 5;           ///< of equal shares
  int number = 0;          ///< of the share that is held out
  bool held_out = true;    ///< that share, or out of the rest
  std::uint64_t from = 0;  ///< of the rest, positions [from, to)
  std::uint64_t to = 0;
  std::uint64_t seed = 1;  ///< of the order

  bool operator==(const FoldPart&) const = default;
};

/// Frames out of an HDF5 file of the user's, measured or made elsewhere:
///
///     /voltages            [N, channels], in the order of channels_of(sensor)
///     /reference_voltages  [channels], or one for each frame [N, channels]
///     /conductivity        [N, grid, grid] S/m, row 0 at the least y; or
///     /contacts            [N, contacts, 2 ... 4]: x and y from the sheet's centre, radius, mm,
///     and
///                          conductivity ratio, or 7 columns as in the files of generated sets; or
///     /positions_mm        [N, 2] from the sheet's centre
///
/// Without any of the last three nothing is known but the frames. What a place does not come with
/// has the declared size and ratio of `contact`.
struct MeasuredFrames {
  std::filesystem::path file;  ///< where it lies; empty where a recipe alone is known
  std::string name;            ///< of the file, without its folder
  std::string checksum;        ///< of its bytes
  std::uint64_t first = 0;     ///< rows [first, last)
  std::uint64_t last = 0;
  std::optional<FoldPart> fold;
  double scale = 1;  ///< V for each unit of the file's voltages

  /// The contact that is drawn at a place of which nothing else is known.
  double radius_mm = 0;
  double conductivity_ratio = 0.5;
  /// A dataset [N] of numbers > 0 in which the strength 1 - ratio is linear, and the number at
  /// which it is that of `conductivity_ratio`; empty where all contacts are alike.
  std::string strength_of;
  double full_strength = 1;

  Truth truth;
  std::uint64_t contacts = 1;  ///< that a frame has room for

  /// The rows of the file in the order of the set's frames.
  std::vector<std::uint64_t> rows() const;
};

/// Reads `{"file", "rows", "fold", "contact", "scale", "checksum"}`. With a `folder`, against which
/// "file" is resolved, the file is looked at, in a process of its own, and must hold what it
/// should: throws InputError where it is missing, damaged, or has links to other files, rows are
/// outside, channels or images are not the sensor's, values are not finite, places are off the
/// sheet. Without one the object is to_json's, and nothing is opened.
MeasuredFrames measured_frames_from_json(JsonObject& object, const Sensor& sensor,
                                         const std::optional<std::filesystem::path>& folder);

/// Adds all keys. The checksum, not the folder, says which file it was.
void add_to(nlohmann::json& json, const MeasuredFrames& measured);
nlohmann::ordered_json measured_schema();

}  // namespace ertbench
