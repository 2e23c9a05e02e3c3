#include "forward/sheet/sensor.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "core/errors.h"
#include "core/json.h"

namespace ertbench {
namespace {

constexpr const char* pattern_forms =
    R"(must be "adjacent", "opposite", {"skip": k} or a list of pairs [first, second])";

std::vector<ElectrodePair> listed_pairs(JsonObject& object, const std::string& key,
                                        int electrodes) {
  std::vector<ElectrodePair> pairs;
  for (const nlohmann::json& pair : object.raw(key)) {
    const bool are_two = pair.is_array() && pair.size() == 2 && pair[0].is_number_integer() &&
                         pair[1].is_number_integer();
    if (!are_two) object.fail(key, std::string(pattern_forms) + ", got " + json_shown(pair));
    for (const nlohmann::json& electrode : pair) {
      if (electrode < 0 || electrode >= electrodes) {
        object.fail(key, "names electrodes from 0 to " + std::to_string(electrodes - 1) + ", got " +
                             json_shown(electrode));
      }
    }
    if (pair[0] == pair[1]) {
      object.fail(key, "must name two different electrodes, got " + json_shown(pair));
    }
    pairs.push_back({pair[0].get<int>(), pair[1].get<int>()});
  }
  if (pairs.empty() || pairs.size() > 4096) {
    object.fail(key, "must hold 1 to 4096 pairs, holds " + std::to_string(pairs.size()));
  }
  return pairs;
}

bool share_electrode(const ElectrodePair& a, const ElectrodePair& b) {
  return a.first == b.first || a.first == b.second || a.second == b.first || a.second == b.second;
}

/// The place of a pair in a list with this index, at whose end it is put where it is new.
int place_of(const ElectrodePair& pair, std::map<ElectrodePair, int>& index,
             std::vector<ElectrodePair>& list) {
  const auto [found, is_new] = index.try_emplace(pair, static_cast<int>(list.size()));
  if (is_new) list.push_back(pair);
  return found->second;
}

/// What is wrong with a channel of a list; empty if nothing is.
std::string fault_of(const Sensor& sensor, const ChannelElectrodes& channel) {
  const auto& [drive, measurement] = channel;
  for (const int e : {drive.first, drive.second, measurement.first, measurement.second}) {
    if (e < 0 || e >= sensor.electrode_count) {
      return "names an electrode that the sensor does not have, which has " +
             std::to_string(sensor.electrode_count);
    }
  }
  if (drive.first == drive.second || measurement.first == measurement.second) {
    return "drives or measures between an electrode and itself";
  }
  if (sensor.electrode_model == ElectrodeModel::point && share_electrode(drive, measurement)) {
    return "measures at a driven point, where the potential is infinite; leave it out or add "
           "\"electrode_model\"";
  }
  return "";
}

}  // namespace

std::vector<ElectrodePair> pairs_of(const PairPattern& pattern, int electrodes) {
  if (pattern.kind == PairPattern::Kind::listed) return pattern.listed;
  int step = 1;
  if (pattern.kind == PairPattern::Kind::skip) step = 1 + pattern.skip;
  if (pattern.kind == PairPattern::Kind::opposite) step = electrodes / 2;
  std::vector<ElectrodePair> pairs;
  for (int k = 0; k < electrodes; ++k) pairs.push_back({k, (k + step) % electrodes});
  return pairs;
}

PairPattern pair_pattern_from_json(JsonObject& object, const std::string& key,
                                   const PairPattern& fallback, int electrodes) {
  PairPattern pattern = fallback;
  if (object.has(key)) {
    const nlohmann::json& value = object.raw(key);
    pattern = {};
    if (value.is_string()) {
      if (object.choice(key, {"adjacent", "opposite"}) == "opposite") {
        pattern.kind = PairPattern::Kind::opposite;
      }
    } else if (value.is_object()) {
      JsonObject skip = object.object(key);
      pattern.kind = PairPattern::Kind::skip;
      pattern.skip = skip.integer("skip", 0, electrodes - 2);
      skip.finish();
      if (pattern.skip == 0) pattern = {};  // another word for "adjacent"
    } else if (value.is_array()) {
      pattern.kind = PairPattern::Kind::listed;
      pattern.listed = listed_pairs(object, key, electrodes);
    } else {
      object.fail(key, std::string(pattern_forms) + ", got " + json_shown(value));
    }
  }
  if (pattern.kind == PairPattern::Kind::opposite && electrodes % 2 != 0) {
    object.fail(key, "\"opposite\" needs an even number of electrodes, the sensor has " +
                         std::to_string(electrodes) + R"(; use {"skip": k})");
  }
  return pattern;
}

nlohmann::json to_json(const PairPattern& pattern) {
  switch (pattern.kind) {
    case PairPattern::Kind::adjacent:
      return "adjacent";
    case PairPattern::Kind::opposite:
      return "opposite";
    case PairPattern::Kind::skip:
      return {{"skip", pattern.skip}};
    default:
      break;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const ElectrodePair& pair : pattern.listed) list.push_back({pair.first, pair.second});
  return list;
}

double Sensor::current_of(int drive_pair) const {
  return drive_currents.empty() ? drive_current
                                : drive_currents[static_cast<std::size_t>(drive_pair)];
}

void Sensor::set_currents(std::vector<double> by_drive_pair) {
  drive_currents = std::move(by_drive_pair);
  drive_current = std::accumulate(drive_currents.begin(), drive_currents.end(), 0.0) /
                  static_cast<double>(drive_currents.size());
}

int Sensor::channels() const {
  if (is_adjacent() && !measures_driven) return electrode_count * (electrode_count - 3);
  return static_cast<int>(channels_of(*this).size());
}

int Sensor::drives() const {
  return drive.kind == PairPattern::Kind::listed ? static_cast<int>(drive.listed.size())
                                                 : electrode_count;
}

int Sensor::measurements() const {
  return measurement.kind == PairPattern::Kind::listed ? static_cast<int>(measurement.listed.size())
                                                       : electrode_count;
}

double Sensor::electrode_spacing() const {
  const double length = sheet->border_length();
  if (electrode_places.empty()) return length / electrode_count;
  std::vector<double> sorted = electrode_places;
  for (double& place : sorted) place -= length * std::floor(place / length);
  std::sort(sorted.begin(), sorted.end());
  double least = sorted.front() + length - sorted.back();
  for (std::size_t e = 1; e < sorted.size(); ++e)
    least = std::min(least, sorted[e] - sorted[e - 1]);
  return least;
}

bool Sensor::operator==(const Sensor& other) const {
  return image_grid == other.image_grid && electrode_count == other.electrode_count &&
         electrode_offset == other.electrode_offset && drive_current == other.drive_current &&
         background == other.background && electrode_places == other.electrode_places &&
         electrode_model == other.electrode_model && electrode_width == other.electrode_width &&
         contact_impedance == other.contact_impedance && drive == other.drive &&
         measurement == other.measurement && measures_driven == other.measures_driven &&
         listed_channels == other.listed_channels && drive_currents == other.drive_currents &&
         sheet->name() == other.sheet->name() && sheet->unit_mm() == other.sheet->unit_mm() &&
         sheet->size_mm() == other.sheet->size_mm() && skin == other.skin;
}

std::vector<ElectrodePair> drive_pairs(const Sensor& sensor) {
  return pairs_of(sensor.drive, sensor.electrode_count);
}

std::vector<ElectrodePair> measurement_pairs(const Sensor& sensor) {
  return pairs_of(sensor.measurement, sensor.electrode_count);
}

SensorPairs::SensorPairs(const Sensor& sensor) {
  std::map<ElectrodePair, int> index;
  for (const ElectrodePair& drive : drive_pairs(sensor)) place_of(drive, index, pairs);
  for (const auto& [drive, measurement] : electrodes_of_channels(sensor)) {
    channels.push_back({place_of(measurement, index, pairs), place_of(drive, index, pairs)});
  }
  for (const Channel& channel : channels_of(sensor)) {
    currents.push_back(sensor.current_of(channel.drive));
  }
}

std::vector<Channel> channels_of(const Sensor& sensor) {
  if (!sensor.listed_channels.empty()) return sensor.listed_channels;
  std::vector<Channel> channels;
  const std::vector<ElectrodePair> drives = drive_pairs(sensor);
  const std::vector<ElectrodePair> measurements = measurement_pairs(sensor);
  for (std::size_t drive = 0; drive < drives.size(); ++drive) {
    for (std::size_t measurement = 0; measurement < measurements.size(); ++measurement) {
      if (!sensor.measures_driven && share_electrode(drives[drive], measurements[measurement])) {
        continue;
      }
      channels.push_back({static_cast<int>(drive), static_cast<int>(measurement)});
    }
  }
  return channels;
}

std::vector<ChannelElectrodes> electrodes_of_channels(const Sensor& sensor) {
  const std::vector<ElectrodePair> drives = drive_pairs(sensor);
  const std::vector<ElectrodePair> measurements = measurement_pairs(sensor);
  std::vector<ChannelElectrodes> out;
  for (const Channel& channel : channels_of(sensor)) {
    out.push_back({drives[static_cast<std::size_t>(channel.drive)],
                   measurements[static_cast<std::size_t>(channel.measurement)]});
  }
  return out;
}

Sensor with_channels(Sensor sensor, const std::vector<ChannelElectrodes>& channels) {
  constexpr std::size_t fewest = 4;
  constexpr std::size_t most = 4096;
  if (channels.size() < fewest || channels.size() > most) {
    throw InputError("a list of channels must hold 4 to 4096, holds " +
                     std::to_string(channels.size()));
  }
  std::map<ElectrodePair, double> currents;
  const std::vector<ElectrodePair> old = drive_pairs(sensor);
  for (int d = 0; d < static_cast<int>(old.size()); ++d) {
    currents.try_emplace(old[static_cast<std::size_t>(d)], sensor.current_of(d));
  }
  const bool differ = !sensor.drive_currents.empty();
  sensor.drive = sensor.measurement = {PairPattern::Kind::listed, 0, {}};
  sensor.measures_driven = false;
  sensor.listed_channels.clear();
  sensor.drive_currents.clear();
  std::map<ElectrodePair, int> drives, measurements;
  std::map<ChannelElectrodes, std::size_t> seen;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto [same, is_new] = seen.try_emplace(channels[c], c);
    const std::string fault = is_new ? fault_of(sensor, channels[c])
                                     : "is the same as channel " + std::to_string(same->second);
    if (!fault.empty()) throw InputError("channel " + std::to_string(c) + " " + fault);
    sensor.listed_channels.push_back(
        {place_of(channels[c].drive, drives, sensor.drive.listed),
         place_of(channels[c].measurement, measurements, sensor.measurement.listed)});
  }
  if (!differ) return sensor;
  std::vector<double> kept;
  for (const ElectrodePair& drive : sensor.drive.listed) {
    const auto found = currents.find(drive);
    kept.push_back(found == currents.end() ? sensor.drive_current : found->second);
  }
  sensor.set_currents(std::move(kept));
  return sensor;
}

std::vector<std::array<int, 2>> reciprocal_pairs(const Sensor& sensor) {
  const std::vector<ChannelElectrodes> channels = electrodes_of_channels(sensor);
  const std::vector<double> currents = SensorPairs(sensor).currents;
  std::map<ChannelElectrodes, int> index;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    index.try_emplace(channels[c], static_cast<int>(c));
  }
  std::vector<char> has_partner(channels.size(), 0);
  std::vector<std::array<int, 2>> pairs;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto& [drive, measurement] = channels[c];
    for (const ChannelElectrodes& exchanged :
         {ChannelElectrodes{measurement, drive},
          ChannelElectrodes{{measurement.second, measurement.first},
                            {drive.second, drive.first}}}) {
      const auto found = index.find(exchanged);
      if (found == index.end()) continue;
      const auto p = static_cast<std::size_t>(found->second);
      if (p <= c || has_partner[c] || has_partner[p] || currents[c] != currents[p]) continue;
      has_partner[c] = has_partner[p] = 1;
      pairs.push_back({static_cast<int>(c), found->second});
    }
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!has_partner[c]) pairs.push_back({static_cast<int>(c), static_cast<int>(c)});
  }
  return pairs;
}

Eigen::VectorXd electrode_distances(const Sensor& sensor) {
  Eigen::VectorXd out(sensor.electrode_count);
  for (int e = 0; e < sensor.electrode_count; ++e) {
    out[e] =
        sensor.electrode_places.empty()
            ? sensor.electrode_offset + sensor.sheet->border_length() * e / sensor.electrode_count
            : sensor.electrode_places[static_cast<std::size_t>(e)];
  }
  return out;
}

Eigen::Matrix2Xd electrode_positions(const Sensor& sensor) {
  return electrode_positions(sensor, Eigen::VectorXd::Zero(sensor.electrode_count));
}

Eigen::Matrix2Xd electrode_positions(const Sensor& sensor, const Eigen::VectorXd& displacement) {
  const Eigen::VectorXd along = electrode_distances(sensor);
  Eigen::Matrix2Xd positions(2, sensor.electrode_count);
  for (int e = 0; e < sensor.electrode_count; ++e) {
    positions.col(e) = sensor.sheet->border_point(along[e] + displacement[e]);
  }
  return positions;
}

std::vector<int> electrode_nodes(const Sensor& sensor, int grid) {
  const PixelGrid pixels = sensor.sheet->pixels(grid);
  const Eigen::Matrix2Xd positions = electrode_positions(sensor);
  std::vector<int> nodes;
  for (int e = 0; e < sensor.electrode_count; ++e) {
    const Eigen::Vector2d at = pixels.place(positions.col(e));
    const Eigen::Vector2d nearest = at.array().round();
    if ((at - nearest).cwiseAbs().maxCoeff() > 1e-9) {
      throw InputError("sensor: electrode " + std::to_string(e) +
                       " falls between the nodes of the " + std::to_string(grid) +
                       "-grid; choose electrode_count and electrode_offset so that every electrode "
                       "is a multiple of 2/grid from a corner, or use \"grid\": \"auto\"");
    }
    nodes.push_back(static_cast<int>(nearest.x()) +
                    (pixels.columns() + 1) * static_cast<int>(nearest.y()));
  }
  return nodes;
}

bool fits_grid(const Sensor& sensor, int grid) {
  const Eigen::Vector2d pixel = sensor.sheet->pixels(grid).pixel();
  if (!sensor.sheet->fills_bounds() || std::abs(pixel.x() - pixel.y()) > 1e-12 * pixel.x() ||
      sensor.electrode_model != ElectrodeModel::point) {
    return false;
  }
  try {
    electrode_nodes(sensor, grid);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

}  // namespace ertbench
