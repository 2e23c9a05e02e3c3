#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "bench/contacts/frame_reading.h"

namespace ertbench {

/// `{"contacts": [[x_mm, y_mm, strength, peak, area_mm2], ...], "peak", "sum", "centroid_mm": [x,
/// y], "centroid25_mm": [x, y], "explained"}` in the units of FrameReading; null where there is no
/// value.
nlohmann::json to_json(const FrameReading& reading);

/// The inverse, of a list of them. Throws an exception of any kind where the JSON is none.
std::vector<FrameReading> frame_readings_from_json(const nlohmann::json& list);

}  // namespace ertbench
