#include "forward/sheet/sensor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
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

namespace {

bool share_electrode(const ElectrodePair& a, const ElectrodePair& b) {
  return a.first == b.first || a.first == b.second || a.second == b.first || a.second == b.second;
}

}  // namespace

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
         sheet->name() == other.sheet->name() && sheet->unit_mm() == other.sheet->unit_mm() &&
         sheet->size_mm() == other.sheet->size_mm() && skin == other.skin;
}

std::vector<ElectrodePair> drive_pairs(const Sensor& sensor) {
  return pairs_of(sensor.drive, sensor.electrode_count);
}

std::vector<ElectrodePair> measurement_pairs(const Sensor& sensor) {
  return pairs_of(sensor.measurement, sensor.electrode_count);
}

SensorPairs::SensorPairs(const Sensor& sensor) : pairs(drive_pairs(sensor)) {
  const std::vector<ElectrodePair> measurements = measurement_pairs(sensor);
  int first_measurement = 0;
  if (measurements != pairs) {
    first_measurement = static_cast<int>(pairs.size());
    pairs.insert(pairs.end(), measurements.begin(), measurements.end());
  }
  for (const Channel& channel : channels_of(sensor)) {
    channels.push_back({first_measurement + channel.measurement, channel.drive});
  }
}

std::vector<Channel> channels_of(const Sensor& sensor) {
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

std::vector<std::array<int, 2>> reciprocal_pairs(const Sensor& sensor) {
  const std::vector<Channel> channels = channels_of(sensor);
  const int count = sensor.measurements();
  std::vector<std::array<int, 2>> pairs;
  if (!is_reciprocal(sensor)) {
    for (int c = 0; c < static_cast<int>(channels.size()); ++c) pairs.push_back({c, c});
    return pairs;
  }
  std::vector<int> index(static_cast<std::size_t>(count * count), -1);
  for (int c = 0; c < static_cast<int>(channels.size()); ++c) {
    const Channel& channel = channels[static_cast<std::size_t>(c)];
    index[static_cast<std::size_t>(channel.drive * count + channel.measurement)] = c;
  }
  for (int c = 0; c < static_cast<int>(channels.size()); ++c) {
    const Channel& channel = channels[static_cast<std::size_t>(c)];
    if (channel.drive < channel.measurement) {
      pairs.push_back(
          {c, index[static_cast<std::size_t>(channel.measurement * count + channel.drive)]});
    }
  }
  return pairs;
}

bool is_reciprocal(const Sensor& sensor) {
  if (sensor.is_adjacent()) return !sensor.measures_driven;
  return !sensor.measures_driven && drive_pairs(sensor) == measurement_pairs(sensor);
}

std::vector<int> channels_in_full_frame(const Sensor& sensor) {
  std::vector<int> out;
  for (const Channel& channel : channels_of(sensor)) {
    out.push_back(channel.drive * sensor.measurements() + channel.measurement);
  }
  return out;
}

Frames reduced_frames(const Sensor& sensor, const Frames& frames, const std::string& source) {
  if (frames.cols() == sensor.channels()) return frames;
  const int all = sensor.drives() * sensor.measurements();
  if (frames.cols() == all) return frames(Eigen::all, channels_in_full_frame(sensor));
  throw InputError(source + ": must have " + std::to_string(sensor.channels()) +
                   " channels a frame, or " + std::to_string(all) +
                   " with those of driven electrodes, has " + std::to_string(frames.cols()));
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

namespace {

/// Index that each electrode is mapped to; no value if one falls between two others.
std::optional<std::vector<int>> electrode_map(const Sensor& sensor, const Eigen::Matrix2d& turn) {
  const Eigen::Matrix2Xd places = electrode_positions(sensor);
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  const Eigen::Matrix2Xd turned = (turn * (places.colwise() - middle)).colwise() + middle;
  std::vector<int> to;
  for (Eigen::Index e = 0; e < places.cols(); ++e) {
    Eigen::Index nearest = 0;
    const double distance =
        (places.colwise() - turned.col(e)).colwise().squaredNorm().minCoeff(&nearest);
    if (distance > 1e-18) return std::nullopt;
    to.push_back(static_cast<int>(nearest));
  }
  return to;
}

/// Index that each pair is mapped to in the same and in the opposite direction; -1 without such a
/// pair.
struct PairMap {
  std::vector<int> same, turned;

  PairMap(const std::vector<ElectrodePair>& pairs, const std::vector<int>& to) {
    std::map<std::pair<int, int>, int> index;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      index.try_emplace({pairs[k].first, pairs[k].second}, static_cast<int>(k));
    }
    const auto find = [&](int first, int second) {
      const auto found = index.find({first, second});
      return found == index.end() ? -1 : found->second;
    };
    for (const ElectrodePair& pair : pairs) {
      const int first = to[static_cast<std::size_t>(pair.first)];
      const int second = to[static_cast<std::size_t>(pair.second)];
      same.push_back(find(first, second));
      turned.push_back(find(second, first));
    }
  }
};

/// No value if a channel is mapped to one that is not measured, or changes its sign. A reflection
/// swaps neighbours, which changes the signs of both drive and measurement.
std::optional<std::vector<int>> channel_map(const Sensor& sensor, const std::vector<int>& to) {
  const std::vector<Channel> channels = channels_of(sensor);
  const PairMap drives(drive_pairs(sensor), to);
  const PairMap measurements(measurement_pairs(sensor), to);
  std::map<std::pair<int, int>, int> index;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    index[{channels[c].drive, channels[c].measurement}] = static_cast<int>(c);
  }
  std::vector<int> from(channels.size(), -1);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto drive = static_cast<std::size_t>(channels[c].drive);
    const auto measurement = static_cast<std::size_t>(channels[c].measurement);
    auto found = index.find({drives.same[drive], measurements.same[measurement]});
    if (found == index.end()) {
      found = index.find({drives.turned[drive], measurements.turned[measurement]});
    }
    if (found == index.end() || from[static_cast<std::size_t>(found->second)] >= 0) {
      return std::nullopt;
    }
    from[static_cast<std::size_t>(found->second)] = static_cast<int>(c);
  }
  return from;
}

std::vector<int> pixel_map(const PixelGrid& pixels, const Eigen::Vector2d& middle,
                           const Eigen::Matrix2d& turn) {
  std::vector<int> from(static_cast<std::size_t>(pixels.count()));
  for (int p = 0; p < pixels.count(); ++p) {
    const Eigen::Vector2d place =
        pixels.place(middle + turn * (pixels.centre(p) - middle)).array() - 0.5;
    const int column = static_cast<int>(std::lround(place.x()));
    const int row = static_cast<int>(std::lround(place.y()));
    from[static_cast<std::size_t>(column + pixels.columns() * row)] = p;
  }
  return from;
}

}  // namespace

std::vector<Symmetry> symmetries(const Sensor& sensor) {
  std::vector<Symmetry> out;
  const PixelGrid pixels = sensor.image();
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  for (const Eigen::Matrix2d& turn : sensor.sheet->symmetries()) {
    const auto to = electrode_map(sensor, turn);
    if (!to) continue;
    if (const auto channels = channel_map(sensor, *to)) {
      out.push_back({pixel_map(pixels, middle, turn), *channels});
    }
  }
  return out;
}

}  // namespace ertbench
