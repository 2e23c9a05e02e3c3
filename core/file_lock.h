#pragma once

#include <filesystem>

namespace ertbench {

enum class MissingFolder { refuse, make };

/// The only holder of a file, until it is destroyed. Another process, or thread, that asks for the
/// same file is waited for. The file is made where there is none and left where it is.
class FileLock {
 public:
  /// Throws InputError where the file cannot be made, or the file system has no locks.
  explicit FileLock(const std::filesystem::path& file,
                    MissingFolder folder = MissingFolder::refuse);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

  /// Forces what was written to the file, by whomever, to the disk. Throws InputError where that
  /// fails.
  void sync() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace ertbench
