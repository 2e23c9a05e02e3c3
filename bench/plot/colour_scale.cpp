#include "bench/plot/colour_scale.h"

#include <algorithm>
#include <cmath>

#include "bench/plot/axis.h"

namespace ertbench {
namespace {

struct Bounds {
  double low = 0;
  double high = 0;

  void extend(const Images& images) {
    for (const double value : images.reshaped()) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
};

}  // namespace

ColourScale colour_scale(const Images& truth, const std::vector<Images>& estimates, int ticks) {
  constexpr double slack = 1e-6;  // of a step, against rounding
  Bounds shown;
  shown.extend(truth);
  Bounds all = shown;
  for (const Images& images : estimates) all.extend(images);

  const double span = shown.high - shown.low;
  if (span > 0) {
    shown.low = std::max(all.low, shown.low - (shown.low < 0 ? 0.5 : 0.25) * span);
    shown.high = std::min(all.high, shown.high + (shown.high > 0 ? 0.5 : 0.25) * span);
  } else {
    shown = all;  // a blank truth: whatever a solver shows is an artefact
  }
  if (shown.high - shown.low < 1e-9) shown = {-0.1, 0.1};

  ColourScale scale;
  const double most = std::max(-shown.low, shown.high);
  scale.step = round_step(2 * most, ticks);
  scale.high = scale.step * std::ceil(most / scale.step - slack);
  scale.low = -scale.high;
  scale.below = all.low < scale.low - slack * scale.step;
  scale.above = all.high > scale.high + slack * scale.step;
  return scale;
}

}  // namespace ertbench
