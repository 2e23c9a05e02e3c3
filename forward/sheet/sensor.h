#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "forward/sheet/sheet.h"
#include "forward/sheet/skin.h"

namespace ertbench {

class JsonObject;

/// A resistive sheet with point electrodes on its border, driven and measured by adjacent pairs.
/// The defaults are EIDORS's stock model `d2s` with 16 electrodes.
///
/// Electrodes run clockwise at equal distances along the border, from `electrode_offset` past the
/// sheet's start of the border: the top left corner (-1, 1) of the square. Drive k sends -I into
/// electrode k and +I into k+1 (mod L); measurement j is V_j - V_(j+1). Pairs that share an
/// electrode with the drive are skipped.
struct Sensor {
  int image_grid = 24;             ///< pixels along one side of the image
  int electrode_count = 16;        ///< L
  double electrode_offset = 0.25;  ///< along the border from its start, domain units
  double drive_current = 0.025;    ///< A
  double background = 0.06;        ///< conductivity of the untouched sheet, S/m

  int pixels() const { return image_grid * image_grid; }
  int channels() const { return electrode_count * (electrode_count - 3); }

  /// Never null. Sensors are compared by its name and size.
  std::shared_ptr<const Sheet> sheet = square_sheet();
  /// What lies on the sheet, where touches are more than regions of another conductivity.
  std::optional<Skin> skin;

  /// The pixels of the sensor's images.
  PixelGrid image() const { return sheet->pixels(image_grid); }
  double electrode_spacing() const { return sheet->border_length() / electrode_count; }

  bool operator==(const Sensor& other) const;
};

/// One measured voltage: the drive pair and the measuring pair, both 0 ... L-1.
struct Channel {
  int drive;
  int measurement;
};

/// The channels in the order of the voltages: drive by drive, measurements ascending.
std::vector<Channel> channels_of(const Sensor& sensor);

/// Reciprocity makes V(drive d, measure m) = V(drive m, measure d): for each of the channels()/2
/// such pairs the two channel indices.
std::vector<std::array<int, 2>> reciprocal_pairs(const Sensor& sensor);

/// Electrode positions [2, L] in domain units; with `displacement` [L] each moved so far along the
/// border, clockwise.
Eigen::Matrix2Xd electrode_positions(const Sensor& sensor);
Eigen::Matrix2Xd electrode_positions(const Sensor& sensor, const Eigen::VectorXd& displacement);

/// The grid node `column + (grid + 1) * row` under each electrode; `grid` counts pixels along one
/// side. Throws InputError where an electrode falls between nodes.
std::vector<int> electrode_nodes(const Sensor& sensor, int grid);

/// Reads `{"side_mm", "image_grid", "electrode_count", "electrode_offset", "drive_current",
/// "background", "skin"}`, every key optional.
Sensor sensor_from_json(JsonObject object);
nlohmann::json to_json(const Sensor& sensor);

}  // namespace ertbench
