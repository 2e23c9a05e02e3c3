#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// A sensor's file, `sensors/d2s.json`. Throws InputError at the file's own places.
Sensor read_sensor(const std::filesystem::path& file);
/// Its content as it stands, checked.
nlohmann::json read_sensor_json(const std::filesystem::path& file);

/// The file that a "sensor" names in `file`: beside it, in the folder above, or from the working
/// folder. Throws InputError that names all three where there is none.
std::filesystem::path find_sensor_file(const std::filesystem::path& named,
                                       const std::filesystem::path& file);

}  // namespace ertbench
