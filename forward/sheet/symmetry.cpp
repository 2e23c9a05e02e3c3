#include "forward/sheet/symmetry.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace ertbench {
namespace {

/// Where each electrode goes, or nothing where one would fall between two.
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

/// The pair of neighbours {k, k+1} after the turn, named by its first electrode. A reflection turns
/// the pair round, which changes the sign of drive and measurement alike.
int pair_after(const std::vector<int>& to, int pair) {
  const int count = static_cast<int>(to.size());
  const int first = to[static_cast<std::size_t>(pair)];
  const int second = to[static_cast<std::size_t>((pair + 1) % count)];
  return second == (first + 1) % count ? first : second;
}

std::vector<int> channel_map(const Sensor& sensor, const std::vector<int>& to) {
  const std::vector<Channel> channels = channels_of(sensor);
  std::map<std::pair<int, int>, int> index;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    index[{channels[c].drive, channels[c].measurement}] = static_cast<int>(c);
  }
  std::vector<int> from(channels.size());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const int drive = pair_after(to, channels[c].drive);
    const int measurement = pair_after(to, channels[c].measurement);
    from[static_cast<std::size_t>(index.at({drive, measurement}))] = static_cast<int>(c);
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
    if (const auto to = electrode_map(sensor, turn)) {
      out.push_back({pixel_map(pixels, middle, turn), channel_map(sensor, *to)});
    }
  }
  return out;
}

}  // namespace ertbench
