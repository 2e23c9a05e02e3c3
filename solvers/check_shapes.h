#pragma once

#include <span>
#include <stdexcept>

#include "solvers/solver.h"

namespace ertbench {

/// Refuses calls of `reconstruct` that break its contract: the caller's defect, not the user's.
inline void check_shapes(const Sensor& sensor, bool fitted, const FramesView& changes,
                         const ImagesView& images, std::span<const FrameReport> reports) {
  if (!fitted) throw std::logic_error("reconstruct: the solver is neither fitted nor loaded");
  if (changes.cols() != sensor.channels() || images.cols() != sensor.pixels() ||
      images.rows() != changes.rows() ||
      reports.size() != static_cast<std::size_t>(changes.rows())) {
    throw std::logic_error("reconstruct: frames, images and reports do not fit together");
  }
}

}  // namespace ertbench
