#include "forward/sheet/sensor.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json_reader.h"
#include "forward/sheet/square_sheet.h"

namespace ertbench {
namespace {

bool shares_electrode(int drive, int measurement, int count) {
  const int gap = (measurement - drive + count) % count;
  return gap <= 1 || gap == count - 1;
}

}  // namespace

bool Sensor::operator==(const Sensor& other) const {
  return image_grid == other.image_grid && electrode_count == other.electrode_count &&
         electrode_offset == other.electrode_offset && drive_current == other.drive_current &&
         background == other.background && sheet->name() == other.sheet->name() &&
         sheet->unit_mm() == other.sheet->unit_mm() && skin == other.skin;
}

std::vector<Channel> channels_of(const Sensor& sensor) {
  std::vector<Channel> channels;
  const int count = sensor.electrode_count;
  for (int drive = 0; drive < count; ++drive) {
    for (int measurement = 0; measurement < count; ++measurement) {
      if (!shares_electrode(drive, measurement, count)) channels.push_back({drive, measurement});
    }
  }
  return channels;
}

std::vector<std::array<int, 2>> reciprocal_pairs(const Sensor& sensor) {
  const std::vector<Channel> channels = channels_of(sensor);
  const int count = sensor.electrode_count;
  std::vector<int> index(static_cast<std::size_t>(count * count), -1);
  for (int c = 0; c < static_cast<int>(channels.size()); ++c) {
    const Channel& channel = channels[static_cast<std::size_t>(c)];
    index[static_cast<std::size_t>(channel.drive * count + channel.measurement)] = c;
  }
  std::vector<std::array<int, 2>> pairs;
  for (int c = 0; c < static_cast<int>(channels.size()); ++c) {
    const Channel& channel = channels[static_cast<std::size_t>(c)];
    if (channel.drive < channel.measurement) {
      pairs.push_back(
          {c, index[static_cast<std::size_t>(channel.measurement * count + channel.drive)]});
    }
  }
  return pairs;
}

Eigen::Matrix2Xd electrode_positions(const Sensor& sensor) {
  return electrode_positions(sensor, Eigen::VectorXd::Zero(sensor.electrode_count));
}

Eigen::Matrix2Xd electrode_positions(const Sensor& sensor, const Eigen::VectorXd& displacement) {
  Eigen::Matrix2Xd positions(2, sensor.electrode_count);
  for (int e = 0; e < sensor.electrode_count; ++e) {
    positions.col(e) = sensor.sheet->border_point(
        sensor.electrode_offset + sensor.sheet->border_length() * e / sensor.electrode_count +
        displacement[e]);
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
                       "is a multiple of 2/grid from a corner");
    }
    nodes.push_back(static_cast<int>(nearest.x()) + (grid + 1) * static_cast<int>(nearest.y()));
  }
  return nodes;
}

Sensor sensor_from_json(JsonObject object) {
  Sensor sensor;
  const double side_mm = sensor.sheet->size_mm().x();
  if (object.number_or("side_mm", side_mm, {1, 1e5, false, "mm"}) != side_mm) {
    sensor.sheet = std::make_shared<const SquareSheet>(object.number("side_mm"));
  }
  sensor.image_grid = object.integer_or("image_grid", sensor.image_grid, 4, 96);
  sensor.electrode_count = object.integer_or("electrode_count", sensor.electrode_count, 5, 64);
  sensor.electrode_offset = object.number_or("electrode_offset", sensor.electrode_spacing() / 2,
                                             {0, sensor.sheet->border_length()});
  // From the leakage of an insulator to the best of metals, whose voltages and their squares are
  // numbers of float32 as well.
  sensor.drive_current =
      object.number_or("drive_current", sensor.drive_current, {1e-9, 100, false, "A"});
  sensor.background = object.number_or("background", sensor.background, {1e-9, 1e8, false, "S/m"});
  if (object.has("skin")) {
    sensor.skin = skin_from_json(object.object("skin"), sensor.sheet->size_mm().x());
  }
  object.finish();
  if (sensor.electrode_offset >= sensor.electrode_spacing()) {
    object.fail("electrode_offset", "must be less than the distance between electrodes, " +
                                        std::to_string(sensor.electrode_spacing()));
  }
  try {
    electrode_nodes(sensor, sensor.image_grid);
  } catch (const InputError& e) {
    object.fail("", e.what());
  }
  return sensor;
}

nlohmann::json to_json(const Sensor& sensor) {
  nlohmann::json json = {{"image_grid", sensor.image_grid},
                         {"electrode_count", sensor.electrode_count},
                         {"electrode_offset", sensor.electrode_offset},
                         {"drive_current", sensor.drive_current},
                         {"background", sensor.background}};
  // Left out where they are what they were before there was a choice, so that the names of older
  // datasets stay what they are.
  if (sensor.sheet->unit_mm() != square_sheet()->unit_mm()) {
    json["side_mm"] = sensor.sheet->size_mm().x();
  }
  if (sensor.skin) json["skin"] = to_json(*sensor.skin);
  return json;
}

}  // namespace ertbench
