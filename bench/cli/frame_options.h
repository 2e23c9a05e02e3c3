#pragma once

#include <CLI/CLI.hpp>
#include <memory>

#include "bench/frames/own_frames.h"

namespace ertbench {

/// The options by which `reconstruct` and `calibrate` are told how frames are declared. Files are
/// checked when they are read.
void add_frame_options(CLI::App& command, const std::shared_ptr<OwnFramesOptions>& options);

}  // namespace ertbench
