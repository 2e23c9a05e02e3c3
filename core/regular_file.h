#pragma once

#include <filesystem>

namespace ertbench {

/// Throws InputError unless `file`, or what it is a link to, is a regular file: one that can be
/// read from its beginning to an end, and whose opening does not wait for anybody, as that of a
/// FIFO does.
void require_regular_file(const std::filesystem::path& file);

}  // namespace ertbench
