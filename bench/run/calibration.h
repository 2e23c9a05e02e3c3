#pragma once

namespace ertbench {

/// Time of a fixed piece of work on one thread, the product of a 576 x 104 matrix and a vector in
/// double precision: what a linear solver does for one frame. Median of many, µs. Latencies divided
/// by it can be compared from one machine to the next, roughly.
double calibration_us();

}  // namespace ertbench
