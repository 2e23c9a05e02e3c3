#pragma once

#include <filesystem>

#include "bench/frames/own_frames.h"

namespace ertbench {

/// What there is to say of a calibration.
struct CalibrationOutcome {
  Calibration calibration;
  ReferenceVerdict verdict;
};

/// Calibrates on frames of a file (all of them, or its rows `options.background`), and writes the
/// calibration as JSON to `output`, with "source": OwnFrames::description. Throws InputError for
/// fewer than ten frames, for more than a million, for reference voltages that are beyond help and
/// such as would have to be mended first, unless `force`; and where `output` is something else than
/// a calibration.
CalibrationOutcome calibrate_file(const OwnFramesOptions& options,
                                  const std::filesystem::path& output, bool fix, bool force);

}  // namespace ertbench
