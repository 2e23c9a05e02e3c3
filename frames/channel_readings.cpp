#include <algorithm>
#include <optional>

#include "frames/channels.h"

namespace ertbench {
namespace {

/// Index of a pair in a list, and -1 if it is reversed there.
struct PairPlace {
  int index;
  double sign;
};

std::optional<PairPlace> find_pair(const std::vector<ElectrodePair>& pairs,
                                   const ElectrodePair& pair) {
  for (const double sign : {1.0, -1.0}) {
    const auto found =
        std::ranges::find(pairs, sign > 0 ? pair : ElectrodePair{pair.second, pair.first});
    if (found != pairs.end()) return PairPlace{static_cast<int>(found - pairs.begin()), sign};
  }
  return std::nullopt;
}

/// The instrument's number of an electrode of the sensor.
int instruments_number(int electrode, int shift, bool mirrored, int count) {
  return ((mirrored ? shift - electrode : electrode - shift) + count) % count;
}

/// The reading for an instrument that numbers its electrodes differently but uses the pairs of the
/// sensor. `places` as from places_in_order. Nothing if the pairs do not allow it.
std::optional<ChannelReading> relabelled(const Sensor& sensor, int shift, bool mirrored,
                                         const std::vector<int>& places) {
  const auto drives = drive_pairs(sensor);
  const auto measured = measurement_pairs(sensor);
  const std::vector<Channel> channels = channels_of(sensor);
  std::vector<int> index(drives.size() * measured.size(), -1);
  const auto at = [&](int drive, int measurement) -> int& {
    return index[static_cast<std::size_t>(drive) * measured.size() +
                 static_cast<std::size_t>(measurement)];
  };
  for (std::size_t c = 0; c < channels.size(); ++c) {
    at(channels[c].drive, channels[c].measurement) = static_cast<int>(c);
  }
  const auto named = [&](const ElectrodePair& pair) {
    const int count = sensor.electrode_count;
    return ElectrodePair{instruments_number(pair.first, shift, mirrored, count),
                         instruments_number(pair.second, shift, mirrored, count)};
  };
  ChannelReading reading;
  reading.shift = shift;
  reading.mirrored = mirrored;
  reading.sign.resize(static_cast<Eigen::Index>(channels.size()));
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto drive =
        find_pair(drives, named(drives[static_cast<std::size_t>(channels[c].drive)]));
    const auto measurement =
        find_pair(measured, named(measured[static_cast<std::size_t>(channels[c].measurement)]));
    if (!drive || !measurement) return std::nullopt;
    const int channel = at(drive->index, measurement->index);
    if (channel < 0) return std::nullopt;
    reading.from.push_back(places[static_cast<std::size_t>(channel)]);
    reading.sign[static_cast<Eigen::Index>(c)] = drive->sign * measurement->sign;
  }
  return reading;
}

}  // namespace

std::string ChannelReading::text() const {
  std::string out;
  const auto add = [&](const std::string& part) { out += (out.empty() ? "" : ", ") + part; };
  if (!order.empty()) {
    add(order == "measure-major" ? "drive and measurement are exchanged (order measure-major)"
                                 : "the channels stand in the order " + order);
  }
  if (mirrored) {
    add("the instrument counts its electrodes the other way round, from the sensor's electrode " +
        std::to_string(shift));
  } else if (shift != 0) {
    add("the instrument's electrodes are shifted: its electrode 0 is the sensor's electrode " +
        std::to_string(shift));
  }
  if (rectified) add("the voltages are amplitudes that have lost their signs");
  return out;
}

Eigen::VectorXd ChannelReading::apply(const Eigen::VectorXd& values) const {
  return values(from).cwiseProduct(sign);
}

Frames ChannelReading::apply(const Frames& frames) const {
  Frames out = frames(Eigen::all, from);
  out.array().rowwise() *= sign.transpose().array();
  return out;
}

std::vector<ChannelReading> channel_readings(const Sensor& sensor) {
  std::vector<ChannelReading> readings;
  for (const char* order : {"drive-major", "measure-major", "rotating", "rotating-back"}) {
    const std::vector<int> places = places_in_order(sensor, order);
    if (readings.empty() || places != places_in_order(sensor, "drive-major")) {
      for (const bool mirrored : {false, true}) {
        for (int shift = 0; shift < sensor.electrode_count; ++shift) {
          auto reading = relabelled(sensor, shift, mirrored, places);
          if (!reading) continue;
          if (order != std::string("drive-major")) reading->order = order;
          readings.push_back(std::move(*reading));
        }
      }
    }
  }
  // If an order was declared wrongly, its inverse undoes it.
  for (const char* order : {"rotating", "rotating-back"}) {
    const std::vector<int> places = places_in_order(sensor, order);
    std::vector<int> inverse(places.size());
    for (std::size_t c = 0; c < places.size(); ++c) {
      inverse[static_cast<std::size_t>(places[c])] = static_cast<int>(c);
    }
    if (inverse == places) continue;
    auto reading = relabelled(sensor, 0, false, inverse);
    if (!reading) continue;
    reading->order = std::string("drive-major (and not \"") + order + "\", if that was declared)";
    readings.push_back(std::move(*reading));
  }
  return readings;
}

}  // namespace ertbench
