#include "core/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "core/errors.h"

namespace ertbench {

FileLock::FileLock(const std::filesystem::path& file, MissingFolder folder) : file_(file) {
  for (;;) {
    if (folder == MissingFolder::make) std::filesystem::create_directories(file.parent_path());
    descriptor_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) {
      // The folder may have gone with the lock of another process.
      if (errno == ENOENT && folder == MissingFolder::make) continue;
      throw InputError(file.string() + ": cannot be created: " + std::strerror(errno) +
                       "; check that the folder exists and is writable");
    }
    while (::flock(descriptor_, LOCK_EX) != 0) {
      if (errno == EINTR) continue;
      const int error = errno;
      ::close(descriptor_);
      throw InputError(file.string() + ": cannot be locked: " + std::strerror(error) +
                       "; put the folder on a file system with locks (flock)");
    }
    // Whoever held the lock may have renamed or removed what we opened.
    struct stat opened {};
    struct stat named {};
    if (::fstat(descriptor_, &opened) == 0 && ::stat(file.c_str(), &named) == 0 &&
        opened.st_ino == named.st_ino && opened.st_dev == named.st_dev) {
      return;
    }
    ::close(descriptor_);
  }
}

FileLock::~FileLock() { ::close(descriptor_); }

void FileLock::sync() const {
  if (::fsync(descriptor_) == 0) return;
  throw InputError(file_.string() + ": cannot be written (fsync: " + std::strerror(errno) +
                   "); check the disk");
}

}  // namespace ertbench
