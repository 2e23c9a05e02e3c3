#include "core/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>

#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const char* step, int error) {
  throw InputError(path.string() + ": cannot be written (" + step + ": " +
                   std::generic_category().message(error) +
                   "); check that its folder exists, may be written and has space");
}

/// The file that is written aside; removed again unless it was renamed.
class Aside {
 public:
  Aside(fs::path target, fs::path name) : target_(std::move(target)), name_(std::move(name)) {
    // 0666 less the user's umask, as for any new file.
    descriptor_ = ::open(name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) fail(target_, "open", errno);
  }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;
  ~Aside() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!renamed_) ::unlink(name_.c_str());
  }

  void write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail(target_, "write", errno);
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  void rename() {
    if (::fsync(descriptor_) != 0) fail(target_, "fsync", errno);
    const int descriptor = descriptor_;
    descriptor_ = -1;
    if (::close(descriptor) != 0) fail(target_, "close", errno);
    if (::rename(name_.c_str(), target_.c_str()) != 0) fail(target_, "rename", errno);
    renamed_ = true;
  }

 private:
  fs::path target_;
  fs::path name_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

/// Makes the rename itself last; a file system that cannot do it for folders is no error.
void sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  static std::atomic<unsigned> serial{0};
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  // Unique also where a process of the same number was stopped here before.
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  const std::string name = "." + path.filename().string() + "." + std::to_string(::getpid()) + "-" +
                           std::to_string(serial++) + "-" + std::to_string(now) + ".tmp";
  Aside aside(path, folder / name);
  aside.write(bytes);
  aside.rename();
  sync_folder(folder);
}

}  // namespace ertbench
