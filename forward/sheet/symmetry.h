#pragma once

#include <vector>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// A rotation or reflection of the sheet that maps electrodes onto electrodes. Turning the scene
/// turns image and voltages alike: turned[i] = original[from[i]].
struct Symmetry {
  std::vector<int> pixels;    ///< [pixels], `from` of an image
  std::vector<int> channels;  ///< [channels], `from` of a frame; no channel changes its sign
};

/// Those symmetries of the sheet that are the sensor's too, the identity first. Of the square all
/// eight where the electrodes lie symmetric to its middle lines, the four rotations otherwise,
/// fewer where their number is not a multiple of four.
std::vector<Symmetry> symmetries(const Sensor& sensor);

}  // namespace ertbench
