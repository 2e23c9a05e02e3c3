// A library to be loaded before all others (LD_PRELOAD), in which one call of one kind fails as it
// does where the disk is full, a folder is not ours to write, or memory or processes run out.
//
//   ERTBENCH_FAIL_PROGRAM  the program whose processes count; in all others nothing is done
//   ERTBENCH_FAIL_COUNTS   a file of kind_count 64-bit numbers: the calls so far, of all processes
//   ERTBENCH_FAIL_KIND     the kind that fails: open, write, rename, fsync, malloc or fork
//   ERTBENCH_FAIL_AT       the number of the call that fails, from 1; 0: none, calls are counted
//   ERTBENCH_FAIL_SAYS     a file that is told what failed, "open /dev/null"
//
// Calls count from the beginning of main to its end. Files that are only read fail as well; writing
// fails for regular files alone, as pipes and terminals are never full.

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

// Those of glibc itself, which need no dlsym: that one allocates.
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* __libc_calloc(std::size_t count, std::size_t size);
extern "C" void* __libc_realloc(void* old, std::size_t size);
extern "C" void* __libc_memalign(std::size_t alignment, std::size_t size);

namespace {

enum Kind { opening, writing, renaming, syncing, allocating, forking, kind_count };
constexpr const char* names[kind_count] = {"open", "write", "rename", "fsync", "malloc", "fork"};

std::atomic<std::uint64_t>* counts = nullptr;  ///< null: this process does not count
int failing_kind = -1;
std::uint64_t failing_call = 0;

/// Tells what failed, of what.
void say(Kind kind, const char* of) {
  const char* file = std::getenv("ERTBENCH_FAIL_SAYS");
  if (!file) return;
  const long descriptor =
      ::syscall(SYS_open, file, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (descriptor < 0) return;
  char text[4200];
  const int length = std::snprintf(text, sizeof text, "%s %s\n", names[kind], of);
  static_cast<void>(::syscall(SYS_write, descriptor, text, static_cast<std::size_t>(length)));
  ::close(static_cast<int>(descriptor));
}

/// "libertbench_core.so libstdc++.so.6 ertbench": the libraries through which the call came, the
/// innermost first.
std::string callers() {
  std::string out;
  std::string last;
  void* addresses[40];
  const int count = ::backtrace(addresses, 40);
  for (int i = 0; i < count; ++i) {
    Dl_info found{};
    if (::dladdr(addresses[i], &found) == 0 || !found.dli_fname) continue;
    const std::string path = found.dli_fname;
    const std::string name = path.substr(path.rfind('/') + 1);
    if (name != last && name.find("failing_calls") == std::string::npos) out += " " + name;
    last = name;
  }
  return out;
}

/// Whether this call is the one to fail.
bool fails(Kind kind, const char* of = "") {
  if (!counts) return false;
  const std::uint64_t number = counts[kind].fetch_add(1) + 1;
  if (kind != failing_kind || number != failing_call) return false;
  say(kind, kind == allocating ? callers().c_str() : of);
  return true;
}

int refused(int error) {
  errno = error;
  return -1;
}

template <typename Function>
Function* next(const char* name, Function*) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}
/// The function of this name in the library that would have had it.
#define NEXT(function)                                                 \
  ([] {                                                                \
    static decltype(&::function) found = next(#function, &::function); \
    return found;                                                      \
  }())

bool is_regular(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

bool is_the_program() {
  const char* wanted = std::getenv("ERTBENCH_FAIL_PROGRAM");
  char path[4096];
  const ssize_t length = ::readlink("/proc/self/exe", path, sizeof path - 1);
  return wanted && length > 0 && std::string_view(path, static_cast<std::size_t>(length)) == wanted;
}

void begin_counting() {
  const char* file = std::getenv("ERTBENCH_FAIL_COUNTS");
  const char* kind = std::getenv("ERTBENCH_FAIL_KIND");
  const char* call = std::getenv("ERTBENCH_FAIL_AT");
  if (!file || !is_the_program()) return;
  const int descriptor = NEXT(open)(file, O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return;
  void* const memory = ::mmap(nullptr, kind_count * sizeof(std::uint64_t), PROT_READ | PROT_WRITE,
                              MAP_SHARED, descriptor, 0);
  ::close(descriptor);
  if (memory == MAP_FAILED) return;
  for (int k = 0; k < kind_count; ++k) {
    if (kind && std::strcmp(kind, names[k]) == 0) failing_kind = k;
  }
  failing_call = call ? std::strtoull(call, nullptr, 10) : 0;
  counts = static_cast<std::atomic<std::uint64_t>*>(memory);
}

using Main = int (*)(int, char**, char**);
Main program_main = nullptr;

int counted_main(int argc, char** argv, char** environment) {
  begin_counting();
  const int code = program_main(argc, argv, environment);
  counts = nullptr;
  return code;
}

/// open takes a third argument where it may make a file.
mode_t mode_of(int flags, va_list arguments) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

}  // namespace

extern "C" {

int __libc_start_main(Main main, int argc, char** argv, void (*init)(), void (*fini)(),
                      void (*rtld_fini)(), void* stack_end) {
  program_main = main;
  using Start = int(Main, int, char**, void (*)(), void (*)(), void (*)(), void*);
  auto* const start = reinterpret_cast<Start*>(::dlsym(RTLD_NEXT, "__libc_start_main"));
  return start(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}

#define DEFINE_OPEN(name)                                                          \
  int name(const char* path, int flags, ...) {                                     \
    va_list arguments;                                                             \
    va_start(arguments, flags);                                                    \
    const mode_t mode = mode_of(flags, arguments);                                 \
    va_end(arguments);                                                             \
    return fails(opening, path) ? refused(EACCES) : NEXT(name)(path, flags, mode); \
  }
DEFINE_OPEN(open)
DEFINE_OPEN(open64)

#define DEFINE_OPENAT(name)                                                                \
  int name(int folder, const char* path, int flags, ...) {                                 \
    va_list arguments;                                                                     \
    va_start(arguments, flags);                                                            \
    const mode_t mode = mode_of(flags, arguments);                                         \
    va_end(arguments);                                                                     \
    return fails(opening, path) ? refused(EACCES) : NEXT(name)(folder, path, flags, mode); \
  }
DEFINE_OPENAT(openat)
DEFINE_OPENAT(openat64)

FILE* fopen(const char* path, const char* mode) {
  if (!fails(opening, path)) return NEXT(fopen)(path, mode);
  errno = EACCES;
  return nullptr;
}
FILE* fopen64(const char* path, const char* mode) {
  if (!fails(opening, path)) return NEXT(fopen64)(path, mode);
  errno = EACCES;
  return nullptr;
}

ssize_t write(int file, const void* bytes, size_t size) {
  return is_regular(file) && fails(writing) ? refused(ENOSPC) : NEXT(write)(file, bytes, size);
}
ssize_t writev(int file, const iovec* parts, int count) {
  return is_regular(file) && fails(writing) ? refused(ENOSPC) : NEXT(writev)(file, parts, count);
}
ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  return fails(writing) ? refused(ENOSPC) : NEXT(pwrite)(file, bytes, size, at);
}
ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  return fails(writing) ? refused(ENOSPC) : NEXT(pwrite64)(file, bytes, size, at);
}

int rename(const char* from, const char* to) noexcept {
  return fails(renaming, to) ? refused(EACCES) : NEXT(rename)(from, to);
}
int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept {
  return fails(renaming, to) ? refused(EACCES) : NEXT(renameat)(from_folder, from, to_folder, to);
}

int fsync(int file) { return fails(syncing) ? refused(EIO) : NEXT(fsync)(file); }
int fdatasync(int file) { return fails(syncing) ? refused(EIO) : NEXT(fdatasync)(file); }

pid_t fork() noexcept { return fails(forking) ? refused(EAGAIN) : NEXT(fork)(); }

void* malloc(size_t size) noexcept {
  if (!fails(allocating)) return __libc_malloc(size);
  errno = ENOMEM;
  return nullptr;
}
void* calloc(size_t count, size_t size) noexcept {
  if (!fails(allocating)) return __libc_calloc(count, size);
  errno = ENOMEM;
  return nullptr;
}
void* realloc(void* old, size_t size) noexcept {
  if (!fails(allocating)) return __libc_realloc(old, size);
  errno = ENOMEM;
  return nullptr;
}
void* aligned_alloc(size_t alignment, size_t size) noexcept {
  if (!fails(allocating)) return __libc_memalign(alignment, size);
  errno = ENOMEM;
  return nullptr;
}
int posix_memalign(void** out, size_t alignment, size_t size) noexcept {
  if (fails(allocating)) return ENOMEM;
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : ENOMEM;
}

}  // extern "C"
