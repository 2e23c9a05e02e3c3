#include "core/files.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <thread>

#include "core/build_stamp.h"
#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(TemporaryFolder, IsNewAndGoesWithItsOwner) {
  fs::path path;
  {
    const TemporaryFolder one("twin");
    const TemporaryFolder other("twin");
    EXPECT_NE(one.path(), other.path());
    path = one.path();
    write(one / "file", "text");
    EXPECT_TRUE(fs::exists(path));
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST(HashOfFile, IsOfTheContentsAndOfNothingElse) {
  const TemporaryFolder folder;
  write(folder / "a", "text");
  EXPECT_EQ(hash_of_file(folder / "a"), hash_of("text"));
  EXPECT_THROW(hash_of_file(folder / "missing"), InputError);
  EXPECT_THROW(hash_of_file(folder.path()), InputError);
}

TEST(FileLock, AnotherHolderWaits) {
  const TemporaryFolder folder;
  std::atomic<bool> taken = false;
  std::thread other;
  {
    const FileLock lock(folder / "lock");
    other = std::thread([&] {
      const FileLock second(folder / "lock");
      taken = true;
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    EXPECT_FALSE(taken);
  }
  other.join();
  EXPECT_TRUE(taken);
}

TEST(FileLock, IsOfTheNameAndNotOfAFileThatWasRenamed) {
  const TemporaryFolder folder;
  std::thread other;
  {
    const FileLock lock(folder / "file.part");
    other = std::thread([&] {
      const FileLock second(folder / "file.part");
      EXPECT_TRUE(fs::exists(folder / "file.part"));
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    fs::rename(folder / "file.part", folder / "file");
  }
  other.join();
  EXPECT_EQ(files_in(folder.path()), 2u);
}

TEST(FileLock, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  EXPECT_THROW(FileLock(folder / "none" / "lock"), InputError);
  const FileLock lock(folder / "none" / "lock", MissingFolder::make);
  EXPECT_TRUE(fs::exists(folder / "none" / "lock"));
}

TEST(ReplaceFile, IsWholeOrAsItWas) {
  const TemporaryFolder folder;
  write(folder / "file", "old");
  EXPECT_THROW(replace_file(folder / "file",
                            [](const fs::path& aside) {
                              write(aside, "half");
                              throw std::runtime_error("interrupted");
                            }),
               std::runtime_error);
  EXPECT_EQ(content_of(folder / "file"), "old");
  EXPECT_EQ(files_in(folder.path()), 1u);
  replace_file(folder / "file", [](const fs::path& aside) { write(aside, "new"); });
  EXPECT_EQ(content_of(folder / "file"), "new");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(ReplaceFile, LeavesNothingWhereItCannotBePutInPlace) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "taken" / "by a folder");
  EXPECT_THROW(replace_file(folder / "taken", [](const fs::path& aside) { write(aside, "text"); }),
               InputError);
  EXPECT_EQ(files_in(folder.path()), 1u);
}

/// Runs a part of a test in another process; whether it was not killed and nothing failed in it.
bool in_another_process(const std::function<void()>& part) {
  const pid_t process = ::fork();
  if (process == 0) {
    part();
    ::_exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  ::waitpid(process, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

TEST(TemporaryFolder, OfAKilledProcessGoesWithTheNext) {
  const TemporaryFolder place;
  const auto made_in_it = [&](const std::function<void(const fs::path&)>& use) {
    return in_another_process([&] {
      ::setenv("TMPDIR", place.path().c_str(), 1);
      use(TemporaryFolder("left").path());
    });
  };
  EXPECT_FALSE(made_in_it([](const fs::path& folder) {
    write(folder / "drawing", "half");
    ::raise(SIGKILL);
  }));
  EXPECT_EQ(files_in(place.path()), 1u);
  EXPECT_TRUE(made_in_it([](const fs::path&) {}));
  EXPECT_EQ(files_in(place.path()), 1u) << "it may be that its owner has not locked it yet";
  const fs::path left = fs::directory_iterator(place.path())->path();
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::minutes(2));
  // Not ours, whatever they are called.
  for (const char* name : {"ertbench", "ertbench_results", "ertbench_cache_a1B2c3"}) {
    fs::create_directory(place / name);
    fs::last_write_time(place / name, fs::file_time_type::clock::now() - std::chrono::minutes(2));
  }
  // One that somebody holds stays, however old it is.
  EXPECT_TRUE(made_in_it([&](const fs::path& held) {
    fs::last_write_time(held, fs::file_time_type::clock::now() - std::chrono::minutes(2));
    EXPECT_FALSE(fs::exists(left));
    EXPECT_TRUE(in_another_process([&] {
      const TemporaryFolder other;
      EXPECT_TRUE(fs::exists(held));
    }));
  }));
  EXPECT_EQ(files_in(place.path()), 3u);
}

}  // namespace
}  // namespace ertbench
