#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "forward/sheet/sensor.h"

namespace ertbench {
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

/// No value if a channel is mapped to one that is not measured, has another current or changes its
/// sign. A reflection swaps neighbours, which changes the signs of both drive and measurement.
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
    if (found == index.end()) return std::nullopt;
    const auto to_channel = static_cast<std::size_t>(found->second);
    const bool same_current =
        sensor.current_of(channels[c].drive) == sensor.current_of(channels[to_channel].drive);
    if (!same_current || from[to_channel] >= 0) return std::nullopt;
    from[to_channel] = static_cast<int>(c);
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
