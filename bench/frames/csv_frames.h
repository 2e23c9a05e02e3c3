#pragma once

#include <filesystem>
#include <memory>
#include <string_view>

#include "bench/frames/frame_source.h"

namespace ertbench {

/// Frames of a text file, one a line: numbers with a point, apart by commas, semicolons, tabs or
/// blanks. Lines that begin with "#" and empty ones are passed over, and so is a first line that
/// holds a word (titles of columns). Throws InputError with line and column for what is no number,
/// is not finite, or makes a line longer or shorter than the first.
std::unique_ptr<FrameSource> open_csv_frames(const std::filesystem::path& input,
                                             const FrameFileOptions& options);

/// The numbers of such a text, [lines, columns]; `source` names it in messages.
RowMajorMatrix numbers_of_text(std::string_view text, const std::string& source);

}  // namespace ertbench
