#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ertbench {

/// Writes `bytes` to another file in the same folder, forces it to the disk and renames it over
/// `path`, so that `path` always holds either the old or the whole new file. Throws InputError
/// naming the file and the cause, and leaves nothing behind then.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

/// Kind of file that a command writes; it overwrites no other.
struct OutputKind {
  std::string name;  ///< for messages: "file of images"
  /// True if a regular file is of this kind.
  std::function<bool(const std::filesystem::path& file)> is_one;
};

/// Throws InputError unless `output` may be written: it does not exist, or is a file of its kind
/// and none of the `inputs`, compared by file and not by name.
void require_output(const std::filesystem::path& output,
                    const std::vector<std::filesystem::path>& inputs, const OutputKind& kind);

/// Throws InputError unless `file`, or the target of this link, is a regular file. Opening a FIFO
/// or a device could wait forever.
void require_regular_file(const std::filesystem::path& file);

/// Writes all bytes to a descriptor; false, and errno says why, if it takes no more.
bool write_all(int descriptor, std::string_view bytes);

/// The bytes of a file; empty if it does not exist or cannot be read.
std::string contents_of(const std::filesystem::path& file);

/// Name, unique to this process, under which `file` is written before it is renamed.
std::filesystem::path aside_of(const std::filesystem::path& file);

/// Renames `aside` to `file`. Throws InputError on failure, and removes `aside` then.
void put_in_place(const std::filesystem::path& aside, const std::filesystem::path& file);

/// Calls `write(aside)`, which writes a file beside `file`, and renames it to `file`, so that
/// `file` is whole whenever the process ends. A killed process leaves `aside` behind; under a lock
/// give it a fixed name, which the next process overwrites. Exceptions of `write` are passed on and
/// nothing is left behind. For bytes in memory use write_file_atomically.
template <typename Write>
void replace_file(const std::filesystem::path& file, Write&& write,
                  const std::filesystem::path& aside) {
  try {
    write(aside);
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(aside, ignored);
    throw;
  }
  put_in_place(aside, file);
}
template <typename Write>
void replace_file(const std::filesystem::path& file, Write&& write) {
  replace_file(file, std::forward<Write>(write), aside_of(file));
}

/// A new folder in $TMPDIR or /tmp. The destructor removes it with all its contents; if the process
/// was killed, the next one that makes a temporary folder does.
class TemporaryFolder {
 public:
  /// The folder is called `.ertbench_temporary_NAME_XXXXXX`. Throws InputError if it cannot be
  /// made.
  explicit TemporaryFolder(const std::string& name = "work");
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;  ///< on the folder; a folder without a lock has lost its owner
};

enum class MissingFolder { refuse, make };

/// Exclusive lock on a file between processes and threads, held until destruction. The file is made
/// if it is missing, and stays.
class FileLock {
 public:
  /// Waits for other holders. Throws InputError if the file cannot be made or the file system has
  /// no locks.
  explicit FileLock(const std::filesystem::path& file,
                    MissingFolder folder = MissingFolder::refuse);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

  /// Forces all writes to the file to the disk. Throws InputError on failure.
  void sync() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace ertbench
