#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "core/frame_front.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// What a frame check does before an image, as data, from the numbers of FrameCheck::packed; it
/// tells nothing. Throws InputError for a check without limits.
FrameFront front_numbers(const Sensor& sensor, ElectrodeSet masked, const Eigen::VectorXd& packed);

/// Bad pairs at which an electrode with this many is dead.
int least_bad_pairs(std::ptrdiff_t pairs);

inline double square(double x) { return x * x; }

inline constexpr int least_pairs = 12;  ///< that can be asked for their noise, or for other pairs

}  // namespace ertbench
