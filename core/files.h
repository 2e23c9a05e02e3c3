#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ertbench {

/// Writes a file that is either the old one or the whole new one, whatever happens meanwhile: into
/// another file in the same folder, forced to the disk, then renamed over `path`. `bytes` may be
/// text or not. Throws InputError naming the file and the cause; nothing is left behind then.
void write_file_atomically(const std::filesystem::path& path, std::string_view bytes);

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

/// Throws InputError unless `file`, or what it is a link to, is a regular file: one that can be
/// read from its beginning to an end, and whose opening does not wait for anybody, as that of a
/// FIFO does.
void require_regular_file(const std::filesystem::path& file);

/// The bytes of a file; none where it is not there or cannot be read, as a log that nobody wrote.
std::string contents_of(const std::filesystem::path& file);

/// The name of this process under which a file grows beside its place.
std::filesystem::path aside_of(const std::filesystem::path& file);

/// Puts `aside` in the place of `file`. Throws InputError where that fails; `aside` is gone then.
void put_in_place(const std::filesystem::path& aside, const std::filesystem::path& file);

/// Makes a file by `write(aside)`, which writes another beside it, and puts that in its place: what
/// stands under `file` is whole whenever the process ends. A killed process leaves `aside`; name
/// one where a lock lets no other process write, so that the next one writes over it. What `write`
/// throws is passed on, and nothing is left behind. For bytes in memory that must last there is
/// write_file_atomically.
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
