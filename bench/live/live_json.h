#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "bench/live/live_state.h"

namespace ertbench {

/// "ok", "not converged", "undefined", "suspect".
const char* name_of(FrameStatus status);
/// ["a dead electrode", ...]
nlohmann::json reasons_json(std::uint8_t reasons);

/// What is said of an answer, on standard output and on the page:
///
///     {"status", "reasons", "dead_electrodes", "contacts": [{"x_mm", "y_mm", "strength", "peak",
///      "area_mm2", "force_N"}], "tracks": [{"id", "x_mm", "y_mm", "vx_mm_s", "vy_mm_s", "seen"}],
///      "force_N", "signal", "alarm"}
///
/// Places in mm from the sheet's centre, tracks that are confirmed; "strength" in S/m mm², "peak"
/// and "signal" (the largest |δσ|) in S/m. A contact's force is its share of the frame's by
/// strength. null where there is no value.
nlohmann::json answer_json(const LiveAnswer& answer, const Sensor& sensor);

/// `{"came", "answered", "dropped", "late", "damaged": {"wrong length", ...}}`
nlohmann::json counts_json(const LiveCounts& counts);

/// `{"least_s", "per_decade", "counts"}`: classes from `least_s` on, equally wide on a logarithmic
/// scale.
nlohmann::json histogram_json(const LatencyHistogram& latency);

/// `{"p50", "p99", "max"}`, µs.
nlohmann::json latency_json(const LatencyHistogram& latency);

}  // namespace ertbench
