#pragma once

#include <vector>

#include "bench/record/result_row.h"
#include "core/json_value.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

class DatasetFile;
class Solver;

/// All frames of one test set, scored.
struct ScoredFrames {
  ResultRow row;            ///< its metrics and its counts of frames
  JsonValue frames;         ///< as in the record: {metric: [values], "status", "reasons", ...}
  JsonValue figure_images;  ///< [figure scenes][pixels] S/m
};

/// Reconstructs the set and scores every frame; the images of `figure_scenes` are kept.
ScoredFrames score_set(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
                       const std::vector<int>& figure_scenes);

}  // namespace ertbench
