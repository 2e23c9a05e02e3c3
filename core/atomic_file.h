#pragma once

#include <filesystem>
#include <string_view>

namespace ertbench {

/// Writes a file that is either the old one or the whole new one, whatever happens meanwhile: into
/// another file in the same folder, forced to the disk, then renamed over `path`. `bytes` may be
/// text or not. Throws InputError naming the file and the cause; nothing is left behind then.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

}  // namespace ertbench
