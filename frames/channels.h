#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "frames/frame_source.h"

namespace ertbench {

/// Maps the columns of a file to the channels of a sensor: each channel is a column, or the
/// difference of two potentials, times a factor (unit and sign).
struct ChannelMap {
  struct Entry {
    Eigen::Index plus = 0;
    Eigen::Index minus = -1;  ///< none
    double factor = 1;        ///< to V
  };

  std::string order;           ///< as declared: "drive-major", a file's name
  Eigen::Index columns = 0;    ///< number of columns of a file with this order
  std::vector<Entry> entries;  ///< [channels]

  /// `table` [rows, columns], in the file's unit, to frames [rows, channels] V.
  Frames apply(const RowMajorMatrix& table) const;
  /// A map whose channel c is `factor[c]` times this one's channel `from[c]`.
  ChannelMap mended(const std::vector<int>& from, const Eigen::VectorXd& factor) const;
  ChannelMap of_channels(const std::vector<int>& kept) const;  ///< with these channels alone
  /// The entries as [channels, 3]: column, subtracted column or -1, factor.
  RowMajorMatrix table() const;
};

struct NamedOrder {
  const char* name;
  const char* description;
};

/// - "drive-major", the sensor's own order: drive by drive, measurements ascending.
/// - "measure-major": measurement by measurement, drives ascending.
/// - "rotating": drive by drive, measurements around the sensor from the one after the drive
///   (EIDORS's and pyEIT's "rotate_meas"); "rotating-back": in the opposite direction.
/// - "full", "full-measure-major": all measurements for all drives; those that are no channels
///   (driven electrodes) are dropped.
/// - "potentials": the potential of every electrode against ground, drive by drive.
std::span<const NamedOrder> named_orders();

/// Column of each of the sensor's channels in a file of one of the first four orders, [channels].
/// Throws std::invalid_argument for other orders.
std::vector<int> places_in_order(const Sensor& sensor, const std::string& name);

/// Makes the map of a declared `order`. It is a name, a text file or, beginning with "/", a dataset
/// of the frames' file. Files and datasets have a line "drive measurement" or "drive measurement
/// sign" for each column, counted from 0, or, in a file, "a b m n" of electrodes (read_channels);
/// columns that are no channels are dropped. If `order` is empty, the electrodes that the file
/// names or `.eit` injections give theirs, else the number of columns decides between the sensor's
/// own order and "full". `unit` is "V", "mV" or "uV"; empty: the file's, or V. Throws InputError if
/// the columns do not fit, or a channel is missing or comes twice.
ChannelMap channel_map(const Sensor& sensor, const FrameSource& source, const std::string& order,
                       const std::string& unit);

/// The sensor for columns whose electrodes the source names, or the file `order` with a line "a b m
/// n" for each (read_channels): itself if it lists its channels or if all of them are among the
/// columns, in either direction of the pairs; else with those channels.
Sensor sensor_of_columns(const Sensor& sensor, const FrameSource& source, const std::string& order);

/// The same for frames of a stream, whose number of columns is that of the order; without an order
/// it is the sensor's own.
ChannelMap channel_map(const Sensor& sensor, const std::string& order, const std::string& unit);

/// One interpretation of a frame's values as channels of the sensor.
struct ChannelReading {
  std::vector<int> from;   ///< [channels]: channel c is sign[c] times value from[c]
  Eigen::VectorXd sign;    ///< [channels], 1 or -1
  bool rectified = false;  ///< the values have lost their signs; `sign` restores the model's
  int shift = 0;           ///< the instrument's first electrode is this one of the sensor
  bool mirrored = false;   ///< the instrument counts in the opposite direction
  std::string order;       ///< order of the channels; empty: the sensor's own

  bool is_as_it_came() const { return !rectified && shift == 0 && !mirrored && order.empty(); }
  /// Complexity of the interpretation; of two that fit alike the simpler is chosen.
  int assumptions() const {
    return (order.empty() ? 0 : 1) + (shift == 0 ? 0 : 1) + (mirrored ? 2 : 0) +
           (rectified ? 1 : 0);
  }
  /// "the instrument's first electrode is the sensor's electrode 3 (counted from 0)".
  std::string text() const;

  Eigen::VectorXd apply(const Eigen::VectorXd& values) const;
  Frames apply(const Frames& frames) const;
};

/// All interpretations to try: every electrode as the first, both directions, in all named orders
/// with as many columns as channels. Those that the sensor's pairs do not allow are left out. The
/// unchanged frame comes first.
std::vector<ChannelReading> channel_readings(const Sensor& sensor);

}  // namespace ertbench
