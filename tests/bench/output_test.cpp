// What a command writes is where it was asked to be, or the command fails.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

class OutputFolder : public ::testing::Test {
 protected:
  OutputFolder() {
    testing::write_text(folder_ / "e.json", testing::small_experiment().dump());
    fs::create_directories(folder_ / "out");
  }
  testing::Outcome run() const {
    return testing::run_program(folder_.path(), "run e.json --out out --only tsvd");
  }
  fs::path out() const { return folder_ / "out"; }

 private:
  testing::TemporaryFolder folder_{"output"};
};

TEST_F(OutputFolder, OfOtherFilesIsRefusedAndKept) {
  testing::write_text(out() / "table.md", "mine");
  const testing::Outcome outcome = run();
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.output.find("--out out: has files that are not of a run"), std::string::npos)
      << outcome.output;
  EXPECT_EQ(testing::read_text(out() / "table.md"), "mine");
  EXPECT_FALSE(fs::exists(out() / "records"));
}

TEST_F(OutputFolder, LinksInItAreNotFollowed) {
  fs::create_directories(out() / "records");
  testing::write_text(out().parent_path() / "letter.txt", "mine");
  for (const char* link : {".running", "records/tsvd.accuracy.log"}) {
    fs::create_symlink(out().parent_path() / "letter.txt", out() / link);
    EXPECT_NE(run().exit_code, 0) << link;
    EXPECT_EQ(testing::read_text(out().parent_path() / "letter.txt"), "mine") << link;
    fs::remove(out() / link);
  }
}

TEST_F(OutputFolder, IsUsedAgainByTheNextRun) {
  EXPECT_EQ(run().exit_code, 0);
  EXPECT_EQ(run().exit_code, 0);
}

TEST_F(OutputFolder, IsOfOneRunAtATime) {
  fs::create_directories(out() / "records");
  testing::write_text(out() / ".running", "4711");
  const int other = ::open((out() / ".running").c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(::flock(other, LOCK_EX | LOCK_NB), 0);
  const testing::Outcome outcome = run();
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.output.find("process 4711"), std::string::npos) << outcome.output;
  EXPECT_FALSE(fs::exists(out() / "table.md"));
  ::close(other);
  EXPECT_EQ(run().exit_code, 0);
}

TEST(Output, ThatIsLostIsAnError) {
  const testing::TemporaryFolder folder("lost");
  const testing::Outcome full = testing::run_program(folder.path(), "list >/dev/full");
  EXPECT_EQ(full.exit_code, 2);
}

}  // namespace
}  // namespace ertbench
