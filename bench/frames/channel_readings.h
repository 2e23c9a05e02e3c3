#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

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
