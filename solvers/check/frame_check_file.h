#pragma once

#include "core/hdf5_file.h"
#include "solvers/check/frame_check.h"

namespace ertbench {

/// The dataset `/frame_check`; in a file without one, from before there was one, the check of
/// electrodes that read zero alone. Throws InputError where it is damaged.
FrameCheck load_frame_check(const Hdf5File& file, const Sensor& sensor, ElectrodeSet masked);

}  // namespace ertbench
