#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/studies/alarm_thresholds.h"
#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

// Files that a stream is made ready with. All functions throw InputError naming file and remedy;
// `option` is what the user named the file with.

/// `/voltages`, and what belongs to it where it is there.
struct FramesOfFile {
  Frames voltages;  ///< [frames, channels] V; may hold values that are not finite
  std::optional<Eigen::RowVectorXd> reference;
  std::vector<double> times_s;  ///< [frames] `/time`; empty where there is none
  /// Attribute "sensor"; nothing where the file does not say, as those of instruments do not.
  std::optional<Sensor> sensor;

  /// Throws InputError, naming `file`, unless its frames may be those of `expected`.
  void require(const Sensor& expected, const std::string& file) const;
};
FramesOfFile read_frames_of(const std::string& file, const std::string& option);

/// Frames in which nothing touches.
struct QuietFrames {
  Frames changes;  ///< V, from their own reference
  FrameRuns runs;
};
/// `text` is FILE or FILE@RATE; without a rate `/time` tells it. Runs begin where the time goes
/// back.
QuietFrames read_quiet(const std::string& text, const Sensor& sensor);
/// FILE of such a text.
std::string quiet_file(const std::string& text);

/// Frames of a dataset in which one touch of known force is the only one; the others are left out.
struct ForceFrames {
  Frames changes;
  std::vector<double> forces_N;
};
ForceFrames read_forces(const std::string& file, const Sensor& sensor);

}  // namespace ertbench
