#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

class JsonObject;

/// Two electrodes, 0 ... L-1. A drive injects -I into `first` and +I into `second`; a measurement
/// reads V_first - V_second.
struct ElectrodePair {
  int first;
  int second;
  auto operator<=>(const ElectrodePair&) const = default;
};

/// The electrodes of one channel.
struct ChannelElectrodes {
  ElectrodePair drive;
  ElectrodePair measurement;
  auto operator<=>(const ChannelElectrodes&) const = default;
};

/// One measured voltage: the indices of the drive pair, 0 ... drives()-1, and of the measuring
/// pair, 0 ... measurements()-1, of its sensor.
struct Channel {
  int drive;
  int measurement;
  bool operator==(const Channel&) const = default;
};

/// Pairs by which a sensor is driven or measured: every electrode k with k + 1 ("adjacent"), with
/// k + 1 + skip ("skip") or with k + L/2 ("opposite"; every pair occurs in both directions), all
/// mod L, or a list.
struct PairPattern {
  enum class Kind { adjacent, skip, opposite, listed };

  Kind kind = Kind::adjacent;
  int skip = 0;                       ///< for Kind::skip: electrodes between the two
  std::vector<ElectrodePair> listed;  ///< for Kind::listed

  bool operator==(const PairPattern&) const = default;
  bool is_adjacent() const { return kind == Kind::adjacent; }
};

/// The pairs in their order, for `electrodes` electrodes.
std::vector<ElectrodePair> pairs_of(const PairPattern& pattern, int electrodes);

/// Reads "adjacent", "opposite", {"skip": k} or [[first, second], ...] at `key`, else `fallback`.
/// Throws InputError for electrodes that do not exist, and for "opposite" with an odd number.
PairPattern pair_pattern_from_json(JsonObject& object, const std::string& key,
                                   const PairPattern& fallback, int electrodes);

nlohmann::json to_json(const PairPattern& pattern);

/// Electrode model. `point`: the whole current enters at one point of the border. `gap`: the
/// current is uniform over the electrode's width, and the measured potential is the mean over it.
/// `complete`: a conductor of one potential behind a contact impedance (Cheng et al. 1989), also
/// for electrodes that are not driven.
enum class ElectrodeModel { point, gap, complete };

/// A resistive sheet with electrodes on its border, driven and measured in pairs. The defaults are
/// EIDORS's stock model `d2s` with 16 electrodes.
///
/// Electrodes run clockwise along the border: at equal distances from `electrode_offset` past the
/// sheet's start of the border (Sheet::border_start: the top left corner of a square or rectangle,
/// the top of a disc), or at the `electrode_places` listed. Drive d sends -I into the first
/// electrode of its pair and +I into the second; measurement m is V_first - V_second of its pair.
/// Measurements that share an electrode with the drive are skipped.
///
/// Lengths are in the sheet's domain units; `sheet->unit_mm()` says how long one is.
struct Sensor {
  int image_grid = 24;             ///< pixels along the longer side of the image
  int electrode_count = 16;        ///< L
  double electrode_offset = 0.25;  ///< along the border from its start, domain units
  double drive_current = 0.025;    ///< A
  double background = 0.06;        ///< conductivity of the untouched sheet, S/m

  /// Along the border from its start, clockwise, domain units, [L]; empty: at equal distances.
  std::vector<double> electrode_places = {};
  ElectrodeModel electrode_model = ElectrodeModel::point;
  double electrode_width = 0;    ///< along the border, domain units; 0 for points
  double contact_impedance = 0;  ///< of the complete model, ohm m^2 (ohm m of a sheet 1 m thick)
  PairPattern drive = {};
  PairPattern measurement = {};
  /// True if measurements that share an electrode with the drive are channels too; needs electrodes
  /// with a width.
  bool measures_driven = false;
  /// The channels in their order, of pairs that `drive` and `measurement` list by first appearance
  /// (see with_channels). Empty: all channels of the patterns.
  std::vector<Channel> listed_channels = {};
  /// [drives()] A, of which `drive_current` is the mean; empty: the same for all.
  std::vector<double> drive_currents = {};

  double current_of(int drive_pair) const;               ///< A
  void set_currents(std::vector<double> by_drive_pair);  ///< A, with their mean

  /// The image has `image_grid` pixels along the longer side of the sheet's bounds; the number
  /// along the other side makes pixels nearly square.
  int image_columns() const { return sheet->image_columns(image_grid); }
  int image_rows() const { return sheet->image_rows(image_grid); }
  int pixels() const { return image_columns() * image_rows(); }
  int channels() const;
  int drives() const;        ///< drive pairs
  int measurements() const;  ///< measuring pairs, including skipped ones
  /// True if drives and measurements are both the adjacent pairs, the default.
  bool is_adjacent() const { return drive.is_adjacent() && measurement.is_adjacent(); }

  /// Never null. Sensors are compared by its name and size.
  std::shared_ptr<const Sheet> sheet = square_sheet();
  /// Foam and patches on the sheet; without them contacts are regions of another conductivity.
  std::optional<Skin> skin = {};

  /// Pixels of the sensor's images. Those off the sheet (the corners around a disc) have no change
  /// in any image.
  PixelGrid image() const { return sheet->pixels(image_grid); }
  /// Least distance between neighbouring electrodes along the border, domain units.
  double electrode_spacing() const;

  bool operator==(const Sensor& other) const;
};

std::vector<ElectrodePair> drive_pairs(const Sensor& sensor);
std::vector<ElectrodePair> measurement_pairs(const Sensor& sensor);

/// Drive and measuring pairs in one list; pairs that are both occur once.
struct SensorPairs {
  explicit SensorPairs(const Sensor& sensor);

  std::vector<ElectrodePair> pairs;
  /// [channels] indices of the measuring and of the driving pair in that list.
  std::vector<std::array<int, 2>> channels;
  std::vector<double> currents;  ///< [channels] A
};

/// The channels in the order of the voltages: as listed, or drive by drive, measurements ascending.
std::vector<Channel> channels_of(const Sensor& sensor);
std::vector<ChannelElectrodes> electrodes_of_channels(const Sensor& sensor);  ///< in that order

/// The sensor with a list of channels in place of its own; drives that it has keep their currents.
/// Throws InputError for electrodes that do not exist, pairs of one electrode, a driven point that
/// is measured, a channel that is listed twice, and for fewer than 4 or more than 4096 channels.
Sensor with_channels(Sensor sensor, const std::vector<ChannelElectrodes>& channels);

/// By reciprocity V(drive d, measure m) = V(drive m, measure d) at the same current. Returns the
/// two channel indices of each such pair and after them {c, c} for every channel c without a
/// partner. Pairs that are reversed are partners if both are.
std::vector<std::array<int, 2>> reciprocal_pairs(const Sensor& sensor);

/// Positions of the electrodes' centres along the border, [L] in domain units from its start.
Eigen::VectorXd electrode_distances(const Sensor& sensor);
/// Electrode positions [2, L] in domain units, optionally displaced clockwise along the border by
/// `displacement` [L].
Eigen::Matrix2Xd electrode_positions(const Sensor& sensor);
Eigen::Matrix2Xd electrode_positions(const Sensor& sensor, const Eigen::VectorXd& displacement);

/// The grid node `column + (columns + 1) * row` under each electrode; `grid` counts pixels along
/// the longer side. Throws InputError if an electrode falls between nodes.
std::vector<int> electrode_nodes(const Sensor& sensor, int grid);
/// True if the grid model applies: a square or a rectangle in square pixels, with point electrodes
/// on nodes. Otherwise the border model is used.
bool fits_grid(const Sensor& sensor, int grid);

/// Reads a sensor; every key is optional, the defaults are EIDORS's `d2s`.
///
/// - "shape": "square" with "side_mm", "rectangle" with "sides_mm" [width, height], "disc" with
///   "diameter_mm". A domain unit is half of the square's side, half of the rectangle's longer
///   side, or the disc's radius.
/// - "electrode_count" and "electrode_offset" (or "electrode_offset_mm") for equal distances;
///   "electrode_places" (or "..._mm"), distances along the border; or "electrode_points_mm", points
///   from the sheet's centre, next to the border. "counterclockwise": true numbers electrodes
///   counter-clockwise, from the same first position or in the order listed.
/// - "electrode_model": "point", "gap", "complete"; "electrode_width" (or "..._mm"),
///   "contact_impedance".
/// - "drive", "measurement": see pair_pattern_from_json; "measurement" is "adjacent" unless "drive"
///   is a skip or a list, which it then repeats. "measures_driven": false.
/// - "channels": in place of these a list [[a, b, m, n], ...] or the name of a text file with these
///   four a line, beside the sensor's own: drive a, b and measurement m, n. "count_from": 0 or 1,
///   the first electrode's number; may be left out if the list names 0 or electrode_count.
/// - "drive_currents": A, by drive pair in the order of first appearance, in place of
///   "drive_current" A.
/// - "background" S/m, "image_grid", "skin"; "about", "$schema": ignored.
Sensor sensor_from_json(JsonObject object);
nlohmann::json to_json(const Sensor& sensor);

/// A rotation or reflection of the sheet that maps electrodes onto electrodes. Transforming the
/// scene permutes image and voltages: transformed[i] = original[from[i]].
struct Symmetry {
  std::vector<int> pixels;    ///< [pixels], `from` of an image
  std::vector<int> channels;  ///< [channels], `from` of a frame; no channel changes its sign
};

/// Symmetries of the sheet that map electrodes to electrodes and channels to channels, the identity
/// first. A square, and a disc in its square image, have eight if the electrodes are symmetric
/// about the centre lines, else the four rotations, or fewer if their number is no multiple of
/// four. A rectangle has at most four. With an asymmetric list of pairs only the identity is left.
std::vector<Symmetry> symmetries(const Sensor& sensor);

}  // namespace ertbench
