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

/// Those symmetries of the sheet that are the sensor's too, the identity first: electrodes go to
/// electrodes and every channel to a channel. Of the square, and of a disc in its square image, all
/// eight where the electrodes lie symmetric to its middle lines, the four rotations otherwise,
/// fewer where their number is not a multiple of four; of a rectangle at most four. A list of pairs
/// that has no symmetry leaves the identity.
std::vector<Symmetry> symmetries(const Sensor& sensor);

}  // namespace ertbench
