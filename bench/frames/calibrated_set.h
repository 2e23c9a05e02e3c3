#pragma once

#include <filesystem>
#include <string>

#include "bench/frames/calibration.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// The scenes on which solvers choose what is "auto" and the check of frames finds its limits where
/// nobody gave a set: none to three random contacts on the continuous sheet of the sensor, with the
/// calibration's background and, frame by frame, white noise of its level (absolute basis).
DatasetSpec calibrated_spec(const Calibration& calibration, const Sensor& sensor,
                            const std::string& name);

/// Writes that set as `file`, and puts noise that differs from channel to channel as the
/// calibration's does in the place of the white noise: independent, Gaussian, by channel.
void write_calibrated_set(const Calibration& calibration, const Sensor& sensor,
                          const std::filesystem::path& file, int threads);

}  // namespace ertbench
