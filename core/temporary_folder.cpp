#include "core/temporary_folder.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <ctime>
#include <system_error>

#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// No folder that somebody makes by hand is called so: what begins with it may be removed.
constexpr const char* prefix = ".ertbench_temporary_";

/// Opens a folder and locks it; -1 where that cannot be, or another holds the lock.
int lock_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  return -1;
}

/// Whether it is a folder of our user's, and older than the moment between its making and its
/// locking.
bool may_be_left(const fs::path& folder) {
  constexpr std::time_t moment_s = 60;
  struct stat found {};
  return ::lstat(folder.c_str(), &found) == 0 && S_ISDIR(found.st_mode) &&
         found.st_uid == ::getuid() && found.st_mtime + moment_s < std::time(nullptr);
}

/// Removes what killed processes have left.
void remove_left_folders(const fs::path& place) {
  std::error_code ignored;
  for (fs::directory_iterator entry(place, ignored), end; entry != end; entry.increment(ignored)) {
    const fs::path& folder = entry->path();
    if (!folder.filename().string().starts_with(prefix) || !may_be_left(folder)) continue;
    const int lock = lock_folder(folder);
    if (lock < 0) continue;
    fs::remove_all(folder, ignored);
    ::close(lock);
  }
}

}  // namespace

TemporaryFolder::TemporaryFolder(const std::string& name) {
  const fs::path place = fs::temp_directory_path();
  remove_left_folders(place);
  std::string path = (place / (prefix + name + "_XXXXXX")).string();
  if (::mkdtemp(path.data()) == nullptr) {
    throw InputError(path + ": no temporary folder (" + std::generic_category().message(errno) +
                     "); set TMPDIR to a folder that may be written");
  }
  path_ = path;
  lock_ = lock_folder(path_);
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace ertbench
