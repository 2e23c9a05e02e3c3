#include "core/files.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <system_error>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const char* step, int error) {
  throw InputError(path.string() + ": cannot be written (" + step + ": " +
                   std::generic_category().message(error) +
                   "); check that its folder exists, may be written and has space");
}

/// The file written aside; its destructor removes it unless it was renamed.
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
    if (!write_all(descriptor_, bytes)) fail(target_, "write", errno);
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

/// Makes the rename durable. Not every file system can do that for folders; failures are ignored.
void sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  ::fsync(descriptor);
  ::close(descriptor);
}

const char* kind_of(fs::file_type type) {
  using Type = fs::file_type;
  if (type == Type::directory) return "a directory";
  if (type == Type::fifo) return "a FIFO";
  if (type == Type::socket) return "a socket";
  return type == Type::block || type == Type::character ? "a device" : "no regular file";
}

/// The file beside the missing one that its name may be a slip for, of the same kind; empty where
/// there is none.
std::string near_file(const fs::path& missing) {
  std::vector<std::string> stems;
  std::error_code error;
  const fs::path folder = missing.has_parent_path() ? missing.parent_path() : ".";
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == missing.extension()) stems.push_back(entry.path().stem());
  }
  const std::string near = nearest_word(missing.stem().string(), stems);
  if (near.empty()) return "";
  return fs::path(missing).replace_filename(near + missing.extension().string()).string();
}

/// Folders with this prefix are ours and may be removed.
constexpr const char* prefix = ".ertbench_temporary_";

/// Opens and locks a folder; -1 on failure, or if another process holds the lock.
int lock_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor >= 0 && ::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  if (descriptor >= 0) ::close(descriptor);
  return -1;
}

/// True if it is a folder of our user and older than the moment between its creation and its lock.
bool may_be_left(const fs::path& folder) {
  constexpr std::time_t moment_s = 60;
  struct stat found {};
  return ::lstat(folder.c_str(), &found) == 0 && S_ISDIR(found.st_mode) &&
         found.st_uid == ::getuid() && found.st_mtime + moment_s < std::time(nullptr);
}

/// Removes the folders of killed processes.
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

void write_file_atomically(const fs::path& path, std::string_view bytes) {
  static std::atomic<unsigned> serial{0};
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  // The time keeps it unique if a process of the same number was stopped here before.
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  const std::string name = "." + path.filename().string() + "." + std::to_string(::getpid()) + "-" +
                           std::to_string(serial++) + "-" + std::to_string(now) + ".tmp";
  Aside aside(path, folder / name);
  aside.write(bytes);
  aside.rename();
  sync_folder(folder);
}

void require_output(const fs::path& output, const std::vector<fs::path>& inputs,
                    const OutputKind& kind) {
  std::error_code error;
  const fs::path place = fs::weakly_canonical(output, error);  // of an output that is not there yet
  for (const fs::path& input : inputs) {
    if (fs::equivalent(input, output, error) || fs::weakly_canonical(input, error) == place) {
      throw InputError(output.string() + ": is the input " + input.string() +
                       "; name another output");
    }
  }
  if (!output.parent_path().empty() && !fs::is_directory(output.parent_path(), error)) {
    throw InputError(output.string() + ": there is no folder " + output.parent_path().string() +
                     "; make it first");
  }
  const fs::file_status status = fs::status(output, error);
  if (!fs::exists(status)) return;
  if (fs::is_directory(status)) {
    throw InputError(output.string() + ": is a directory; name a file in it");
  }
  if (!fs::is_regular_file(status) || !kind.is_one(output)) {
    throw InputError(output.string() + ": is there already and is no " + kind.name +
                     ", so that it is left alone; name another output, or remove it");
  }
}

void require_regular_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::regular) return;
  if (status.type() == fs::file_type::not_found) {
    const std::string near = near_file(file);
    throw InputError(file.string() + ": cannot be opened: there is no such file; " +
                     (near.empty() ? "check the name" : "did you mean " + near + "?"));
  }
  if (status.type() == fs::file_type::none) {
    throw InputError(file.string() + ": cannot be opened: " + error.message() +
                     "; check the name and the permissions");
  }
  throw InputError(file.string() + ": is " + kind_of(status.type()) + "; name a regular file");
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::string contents_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

fs::path aside_of(const fs::path& file) {
  fs::path aside = file;
  return aside += "." + std::to_string(::getpid()) + ".part";
}

void put_in_place(const fs::path& aside, const fs::path& file) {
  std::error_code error;
  fs::rename(aside, file, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(aside, ignored);
  throw InputError(file.string() + ": cannot be put in place: " + error.message() +
                   "; check that its folder may be written and that no folder has its name");
}

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
    // The last holder may have renamed or removed the file that we opened.
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
