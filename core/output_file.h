#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace ertbench {

/// What a command may write over: only what it makes itself.
struct OutputKind {
  std::string name;  ///< "file of images", for messages
  /// Whether a regular file is one.
  std::function<bool(const std::filesystem::path& file)> is_one;
};

/// Throws InputError unless `output` may be written: nothing stands there, or a file of its kind
/// that is none of the `inputs`, under whatever name and through whatever link.
void require_output(const std::filesystem::path& output,
                    const std::vector<std::filesystem::path>& inputs, const OutputKind& kind);

}  // namespace ertbench
