#include <nlohmann/json.hpp>

#include "bench/frames/calibration.h"
#include "core/errors.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::vector<double> list_of(const Eigen::VectorXd& values) {
  return {values.begin(), values.end()};
}

Eigen::VectorXd vector_of(JsonObject& object, const char* key, std::size_t size, Range range) {
  const std::vector<double> values = object.numbers(key, size, range);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(size));
}

/// Above what any instrument reaches and below what any number can be.
constexpr double most_volts = 1e9;
constexpr double most_decibels = 1000;

}  // namespace

json to_json(const Calibration& c) {
  return {{"schema", Calibration::schema},
          {"sensor", to_json(c.sensor)},
          {"frames", c.frames},
          {"reference_voltages", list_of(c.reference)},
          {"noise_V", list_of(c.noise)},
          {"white_noise_V", list_of(c.white_noise)},
          {"snr_db",
           {{"absolute", c.snr_absolute},
            {"absolute_white", c.snr_white},
            {"difference", c.snr_difference},
            {"contact",
             {{"radius", Calibration::contact_radius},
              {"conductivity_ratio", Calibration::contact_ratio}}}}},
          {"drift", {{"level", c.drift_level}, {"relative", c.drift}}},
          {"dead_electrodes", c.dead_electrodes},
          {"reciprocity_error", c.reciprocity_error},
          {"level", c.level},
          {"background", c.background},
          {"misfit", c.misfit}};
}

Calibration read_calibration(const std::filesystem::path& file) {
  const json content = read_json_file(file);
  JsonObject object(content, file.string(), "");
  if (!object.has("noise_V") || !object.has("schema")) {
    object.fail("", "is no calibration; `ertbench calibrate` writes one");
  }
  object.integer("schema", Calibration::schema, Calibration::schema);
  Calibration c;
  c.sensor = sensor_from_json(object.object("sensor"));
  const auto channels = static_cast<std::size_t>(c.sensor.channels());
  c.frames = object.integer("frames", 1, 2000000000);
  c.reference = vector_of(object, "reference_voltages", channels, {-most_volts, most_volts});
  c.noise = vector_of(object, "noise_V", channels, {0, most_volts});
  c.white_noise = vector_of(object, "white_noise_V", channels, {0, most_volts});
  JsonObject snr = object.object("snr_db");
  c.snr_absolute = snr.number("absolute", {-most_decibels, most_decibels});
  c.snr_white = snr.number("absolute_white", {-most_decibels, most_decibels});
  c.snr_difference = snr.number("difference", {-most_decibels, most_decibels});
  snr.raw("contact");
  snr.finish();
  JsonObject drift = object.object("drift");
  c.drift_level = drift.number("level");
  c.drift = drift.number("relative");
  drift.finish();
  c.dead_electrodes =
      object.integers("dead_electrodes", 0, static_cast<std::size_t>(c.sensor.electrode_count),
                      {0, c.sensor.electrode_count - 1});
  c.reciprocity_error = object.number("reciprocity_error", Range::at_least(0));
  c.level = object.number("level");
  c.background = object.number("background", {1e-9, 1e8, false, "S/m"});
  c.misfit = object.number("misfit", Range::at_least(0));
  if (object.has("source")) object.raw("source");
  object.finish();
  return c;
}

void require_calibration_of(const Calibration& calibration, const Sensor& sensor,
                            const std::filesystem::path& file) {
  Sensor same = sensor;
  same.background = calibration.sensor.background;
  if (!(same == calibration.sensor)) {
    throw InputError(file.string() + ": /sensor: is another than that of the frames; calibrate " +
                     "again with their --sensor");
  }
}

}  // namespace ertbench
