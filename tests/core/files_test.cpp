#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "core/errors.h"
#include "core/file_lock.h"
#include "core/replace_file.h"
#include "core/temporary_folder.h"

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

}  // namespace
}  // namespace ertbench
