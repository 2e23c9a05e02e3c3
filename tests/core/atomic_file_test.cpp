#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/errors.h"
#include "core/files.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

class AtomicFile : public testing::Test {
 protected:
  AtomicFile() {
    std::string name = (fs::temp_directory_path() / "ertbench-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~AtomicFile() override { fs::remove_all(folder_); }

  static std::string read(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::ptrdiff_t entries() const {
    return std::distance(fs::directory_iterator(folder_), fs::directory_iterator{});
  }

  fs::path folder_;
};

TEST_F(AtomicFile, WritesAndReplacesAllBytes) {
  const fs::path path = folder_ / "table.md";
  const std::string bytes("a\0b\n\xff", 5);
  write_file_atomically(path, std::string(100000, 'x'));
  write_file_atomically(path, bytes);
  EXPECT_EQ(read(path), bytes);
  write_file_atomically(path, "");
  EXPECT_EQ(read(path), "");
  EXPECT_EQ(entries(), 1);  // nothing left aside
}

TEST_F(AtomicFile, MayBeReadByWhoeverMayReadNewFiles) {
  write_file_atomically(folder_ / "a", "text");
  std::ofstream(folder_ / "b") << "text";
  EXPECT_EQ(fs::status(folder_ / "a").permissions(), fs::status(folder_ / "b").permissions());
}

TEST_F(AtomicFile, SaysWhichFileCannotBeWritten) {
  const fs::path path = folder_ / "absent" / "table.md";
  try {
    write_file_atomically(path, "text");
    FAIL() << "wrote into a folder that does not exist";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(path.string()), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("No such file"), std::string::npos) << e.what();
  }
}

TEST_F(AtomicFile, LeavesNothingBehindWhereItFails) {
  fs::create_directories(folder_ / "taken" / "inside");  // cannot be replaced by a file
  EXPECT_THROW(write_file_atomically(folder_ / "taken", "text"), InputError);
  EXPECT_EQ(entries(), 1);
  EXPECT_TRUE(fs::is_directory(folder_ / "taken"));
}

}  // namespace
}  // namespace ertbench
