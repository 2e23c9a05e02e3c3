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

/// Knowledge about the frames of a set beside their voltages; complete for generated sets.
struct Truth {
  bool images = true;  ///< the conductivity of every pixel, not only that of a declared contact
  bool places = true;  ///< where contacts are

  bool operator==(const Truth&) const = default;
};

/// A part of shuffled rows, for cross-validation and for training on fewer rows.
struct FoldPart {
  int count = 5;           ///< number of equal shares
  int number = 0;          ///< index of the share that is held out
  bool held_out = true;    ///< the part is that share, else a slice of the rest
  std::uint64_t from = 0;  ///< positions [from, to) in the rest
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
/// Without any of the last three only the frames are known. A contact whose size and ratio are not
/// in the file has those declared in `contact`.
struct MeasuredFrames {
  std::filesystem::path file;  ///< empty for a recipe without its file
  std::string name;            ///< the file's name without its folder
  std::string checksum;        ///< of its bytes
  std::uint64_t first = 0;     ///< rows [first, last)
  std::uint64_t last = 0;
  std::optional<FoldPart> fold;
  double scale = 1;  ///< V for each unit of the file's voltages

  // The contact that is drawn at a position of which nothing else is known.
  double radius_mm = 0;
  double conductivity_ratio = 0.5;
  /// A dataset [N] of numbers > 0 that 1 - ratio is proportional to; empty if all contacts are
  /// alike. At `full_strength` the ratio is `conductivity_ratio`.
  std::string strength_of;
  double full_strength = 1;

  Truth truth;
  std::uint64_t contacts = 1;  ///< most contacts of a frame

  /// The rows of the file in the order of the set's frames.
  std::vector<std::uint64_t> rows() const;
};

/// Reads `{"file", "rows", "fold", "contact", "scale", "checksum"}`. With a `folder`, which a
/// relative "file" starts from, the file is checked in a process of its own. Throws InputError if
/// it is missing, damaged or has links to other files, or if rows are outside, channels or images
/// are not the sensor's, values are not finite, or positions are off the sheet. Without a folder
/// the object is one written by add_to, and no file is opened.
MeasuredFrames measured_frames_from_json(JsonObject& object, const Sensor& sensor,
                                         const std::optional<std::filesystem::path>& folder);

/// Adds all keys. The file is identified by its checksum, not by its folder.
void add_to(nlohmann::json& json, const MeasuredFrames& measured);
nlohmann::ordered_json measured_schema();

}  // namespace ertbench
