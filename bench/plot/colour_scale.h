#pragma once

#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// What the colours of a figure stand for. The ends are multiples of `step`.
struct ColourScale {
  double low = 0;
  double high = 0;
  double step = 0;     ///< between two ticks
  bool below = false;  ///< values under `low` exist and have its colour
  bool above = false;
};

/// One scale for the true changes and all estimates, zero in its middle, so that a rise and a fall
/// of the conductivity are told apart everywhere by the same colours. It spans all values as far as
/// they leave the range of the truth by no more than half of its width on the side of the contacts
/// and a quarter on the other, so that one image with large artefacts does not pale all others.
/// At most about `ticks` steps. Values that are not finite do not count.
ColourScale colour_scale(const Images& truth, const std::vector<Images>& estimates, int ticks);

}  // namespace ertbench
