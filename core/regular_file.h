#pragma once

#include <filesystem>
#include <string>

namespace ertbench {

/// Throws InputError unless `file`, or what it is a link to, is a regular file: one that can be
/// read from its beginning to an end, and whose opening does not wait for anybody, as that of a
/// FIFO does.
void require_regular_file(const std::filesystem::path& file);

/// The bytes of a file; none where it is not there or cannot be read, as a log that nobody wrote.
std::string contents_of(const std::filesystem::path& file);

}  // namespace ertbench
