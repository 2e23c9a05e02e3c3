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

/// The known truth of the frames of a set. Generated sets know both.
struct Truth {
  bool images = true;  ///< the conductivity of every pixel, not only of declared contacts
  bool places = true;  ///< the positions of contacts

  bool operator==(const Truth&) const = default;
};

/// A subset of shuffled rows, for cross-validation and for training on fewer frames.
struct FoldPart {
  int count = 5;           ///< number of equal folds
  int number = 0;          ///< fold that is held out
  bool held_out = true;    ///< selects that fold, else rows of the others
  std::uint64_t from = 0;  ///< positions [from, to) in the others
  std::uint64_t to = 0;
  std::uint64_t seed = 1;  ///< of the shuffle

  bool operator==(const FoldPart&) const = default;
};

/// Frames out of an HDF5 file of the user's, measured or made elsewhere:
///
///     /voltages            [N, channels], in the order of channels_of(sensor)
///     /reference_voltages  [channels], or one for each frame [N, channels]
///     /conductivity        [N, grid, grid] S/m, row 0 at the least y; or
///     /contacts            [N, contacts, 2 ... 4]: x and y from the sheet's centre and radius, mm,
///                          conductivity ratio, or 7 columns as in the files of generated sets; or
///     /positions_mm        [N, 2] from the sheet's centre
///
/// Without any of the last three there is no truth. Sizes and ratios that are not given are those
/// declared in `contact`.
struct MeasuredFrames {
  std::filesystem::path file;  ///< empty if only a recipe is known
  std::string name;            ///< of the file, without its folder
  std::string checksum;        ///< of its bytes
  std::uint64_t first = 0;     ///< rows [first, last)
  std::uint64_t last = 0;
  std::optional<FoldPart> fold;
  double scale = 1;  ///< V for each unit of the file's voltages

  /// Radius and ratio of a contact of which only the position is known.
  double radius_mm = 0;
  double conductivity_ratio = 0.5;
  /// A dataset [N] of numbers > 0 to which the strength 1 - ratio is proportional, and the number
  /// at which the ratio is `conductivity_ratio`; empty if all contacts have that ratio.
  std::string strength_of;
  double full_strength = 1;

  Truth truth;
  std::uint64_t contacts = 1;  ///< contacts in a row

  /// The rows of the file in the order of the set's frames.
  std::vector<std::uint64_t> rows() const;
};

/// Reads `{"file", "rows", "fold", "contact", "scale", "checksum"}`. With a `folder`, relative to
/// which "file" is resolved, the file is inspected in a child process. Throws InputError if it is
/// missing, damaged or has links to other files, if rows are out of range, if channels or images
/// are not the sensor's, if values are not finite, or if positions are off the sheet. Without a
/// folder the object comes from add_to, and nothing is opened.
MeasuredFrames measured_frames_from_json(JsonObject& object, const Sensor& sensor,
                                         const std::optional<std::filesystem::path>& folder);

/// Adds all keys. The file is identified by its checksum, not by its folder.
void add_to(nlohmann::json& json, const MeasuredFrames& measured);
nlohmann::ordered_json measured_schema();

}  // namespace ertbench
