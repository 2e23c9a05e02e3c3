#pragma once

#include <filesystem>
#include <memory>

#include "bench/frames/frame_source.h"

namespace ertbench {

/// Frames of an HDF5 file: `/voltages` or the dataset that the options name, [N, columns] or, for
/// whole maps, [N, drives, measurements] (its last two flattened, drive by drive).
/// `/reference_voltages` beside it, where it is there.
///
/// MATLAB (v7.3) and Octave (`save -hdf5`) keep arrays with the first index fastest, so that they
/// stand in the file with their dimensions reversed: these are turned round again. In MATLAB's a
/// variable is a dataset, a field of a struct one in a group ("/session/voltages"); cells and
/// complex numbers are refused with what to save in their place. In Octave's a variable is a group
/// with the dataset "value".
std::unique_ptr<FrameSource> open_hdf5_frames(const std::filesystem::path& input,
                                              const FrameFileOptions& options, bool is_matlab);

}  // namespace ertbench
