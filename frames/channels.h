#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "frames/frame_source.h"

namespace ertbench {

/// How the columns of a file become the channels of a sensor: each is a column, or the difference
/// of two (where columns are potentials), times a factor (a unit, a sign).
struct ChannelMap {
  struct Entry {
    Eigen::Index plus = 0;
    Eigen::Index minus = -1;  ///< none
    double factor = 1;        ///< to V
  };

  std::string order;           ///< as it was declared: "drive-major", a file's name
  Eigen::Index columns = 0;    ///< that a file with this order has
  std::vector<Entry> entries;  ///< [channels]

  /// `table` [rows, columns], in the file's unit, to frames [rows, channels] V.
  Frames apply(const RowMajorMatrix& table) const;
  /// The map that makes frames of this one's into others: channel c becomes `factor[c]` times what
  /// channel `from[c]` was.
  ChannelMap mended(const std::vector<int>& from, const Eigen::VectorXd& factor) const;
  /// The entries as [channels, 3]: column, the column that is taken from it or -1, factor.
  RowMajorMatrix table() const;
};

/// An order of columns that has a name. "drive-major" is the sensor's own.
struct NamedOrder {
  const char* name;
  const char* description;
};

/// - "drive-major": drive by drive, measurements ascending.
/// - "measure-major": measurement by measurement, drives ascending.
/// - "rotating": drive by drive, measurements from the one behind the drive on, round the sensor
///   (EIDORS's and pyEIT's "rotate_meas"); "rotating-back": the other way round.
/// - "full", "full-measure-major": whole maps, all measurements for all drives, of which those that
///   are no channels (driven electrodes) are dropped.
/// - "potentials": the potential of every electrode against ground, drive by drive.
std::span<const NamedOrder> named_orders();

/// Where each of the sensor's channels stands in a file of that order, [channels]; orders of as
/// many columns as channels alone (the first four). Throws std::invalid_argument for others.
std::vector<int> places_in_order(const Sensor& sensor, const std::string& name);

/// The map of a declared order: a name; a file of text or, beginning with "/", a dataset of the
/// frames' own file, with a line "drive measurement" or "drive measurement sign" for each column,
/// counted from 0, of which those that are no channels of the sensor are dropped. Empty: by the
/// number of columns, the sensor's own order or "full"; of `.eit` files, by the injections they
/// list. `unit` is "V", "mV" or "uV". Throws InputError where the file's columns do not fit, or a
/// channel is missing or comes twice.
ChannelMap channel_map(const Sensor& sensor, const FrameSource& source, const std::string& order,
                       const std::string& unit);

/// One way to read a frame as it came: which of its values is which channel of the sensor.
struct ChannelReading {
  std::vector<int> from;   ///< [channels]: channel c is sign[c] times value from[c]
  Eigen::VectorXd sign;    ///< [channels], 1 or -1
  bool rectified = false;  ///< the values have lost their signs; `sign` puts the model's back
  int shift = 0;           ///< the instrument's first electrode is this one of the sensor
  bool mirrored = false;   ///< the instrument counts the other way round
  std::string order;       ///< in which the channels stand; empty: the sensor's own

  bool is_as_it_came() const { return !rectified && shift == 0 && !mirrored && order.empty(); }
  /// Of two that explain the same, the one that assumes less.
  int assumptions() const {
    return (order.empty() ? 0 : 1) + (shift == 0 ? 0 : 1) + (mirrored ? 2 : 0) +
           (rectified ? 1 : 0);
  }
  /// "the instrument's first electrode is the sensor's electrode 3 (counted from 0)".
  std::string text() const;

  Eigen::VectorXd apply(const Eigen::VectorXd& values) const;
  Frames apply(const Frames& frames) const;
};

/// All readings that are tried: every electrode as the first, both ways round, in the orders that
/// have names and as many columns as channels, and in drives and measurements exchanged. Those that
/// the sensor's pairs have no room for are left out. As it came first.
std::vector<ChannelReading> channel_readings(const Sensor& sensor);

}  // namespace ertbench
