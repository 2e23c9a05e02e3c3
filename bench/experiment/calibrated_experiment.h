#pragma once

#include <optional>

#include "bench/experiment/experiment.h"
#include "bench/frames/calibration.h"

namespace ertbench {

/// Reads "calibration", the name of a file beside the experiment's: gives the sensor the background
/// that was found, or the whole sensor where the experiment names none. Nothing where there is no
/// such key. Throws InputError where the file is of another sensor.
std::optional<Calibration> read_calibration_of(JsonObject& root, Experiment& experiment);

/// Adds, where it has none, a validation set with noise of the level that was measured.
void complete_with(const Calibration& calibration, Experiment& experiment);

}  // namespace ertbench
