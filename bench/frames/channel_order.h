#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/frames/channel_map.h"
#include "bench/frames/frame_source.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

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

}  // namespace ertbench
