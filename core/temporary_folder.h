#pragma once

#include <filesystem>
#include <string>

namespace ertbench {

/// A new folder in $TMPDIR or /tmp for files that nobody needs afterwards. Goes with its owner, and
/// with all that it holds; where the owner was killed, with the next process that makes one.
class TemporaryFolder {
 public:
  /// `name` is a part of the folder's, `.ertbench_temporary_NAME_XXXXXX`, for people who find it.
  /// Throws InputError where there is no place for it.
  explicit TemporaryFolder(const std::string& name = "work");
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< of the folder: what nobody holds has lost its owner
};

}  // namespace ertbench
