#pragma once

#include <filesystem>
#include <vector>

namespace ertbench {

/// Throws InputError unless `output` may be written by `reconstruct`: nothing stands there, or
/// images that it made, and it is none of the `inputs` (require_output).
void require_image_output(const std::filesystem::path& output,
                          const std::vector<std::filesystem::path>& inputs);

/// What a reconstruction reads: the solver's specification, the checkpoint that it names, frames.
std::vector<std::filesystem::path> reconstruction_inputs(const std::filesystem::path& spec_file,
                                                         const std::filesystem::path& frames);

}  // namespace ertbench
