#include "forward/sheet/sensor.h"

#include <algorithm>
#include <cmath>

#include "core/errors.h"

namespace ertbench {
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

}  // namespace ertbench
