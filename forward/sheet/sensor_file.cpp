#include "forward/sheet/sensor_file.h"

#include <nlohmann/json.hpp>
#include <system_error>

#include "core/errors.h"
#include "core/json_reader.h"

namespace ertbench {

namespace fs = std::filesystem;

nlohmann::json read_sensor_json(const fs::path& file) {
  nlohmann::json json = read_json_file(file);
  sensor_from_json(JsonObject(json, file.string(), ""));  // at the file's own places
  return json;
}

Sensor read_sensor(const fs::path& file) {
  const nlohmann::json json = read_json_file(file);
  return sensor_from_json(JsonObject(json, file.string(), ""));
}

fs::path find_sensor_file(const fs::path& named, const fs::path& file) {
  const fs::path folder = file.parent_path();
  const fs::path beside = folder / named;
  const fs::path above = folder / ".." / named;
  for (const fs::path& place : {beside, above, named}) {
    std::error_code absent;
    if (fs::is_regular_file(place, absent)) return place.lexically_normal();
  }
  throw InputError("no file " + named.string() + ": neither beside " + file.string() +
                   ", nor in the folder above, nor from here; name a sensor's file, such as "
                   "sensors/d2s.json");
}

}  // namespace ertbench
