#pragma once

#include <nlohmann/json.hpp>

#include "core/json.h"
#include "forward/sheet/sensor.h"

namespace ertbench::testing {

inline Sensor sensor_of(const nlohmann::json& value) {
  return sensor_from_json(JsonObject(value, "sensor", ""));
}

inline Sensor disc(nlohmann::json more = nlohmann::json::object()) {
  more["shape"] = "disc";
  more["diameter_mm"] = 200;
  return sensor_of(more);
}

inline Sensor rectangle(nlohmann::json more = nlohmann::json::object()) {
  more["shape"] = "rectangle";
  more["sides_mm"] = {300, 150};
  if (!more.contains("electrode_count")) more["electrode_count"] = 32;
  return sensor_of(more);
}

}  // namespace ertbench::testing
