#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "bench/record/record_file.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using testing::TemporaryFolder;

TEST(ProgressFile, TellsWhatIsDoneAndGoesAway) {
  const TemporaryFolder folder("progress");
  const auto path = folder / "net.seed2.accuracy.progress";
  {
    ProgressFile file(path);
    EXPECT_FALSE(read_progress(path));
    const auto started = std::chrono::steady_clock::now();
    file.update(3, 12, "epoch 3 of 12");
    const auto first = read_progress(path);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->text, "epoch 3 of 12");
    EXPECT_DOUBLE_EQ(first->fraction, 0.25);
    EXPECT_EQ(first->seconds_left, 0);  // nothing to go by
    file.update(4, 12, "epoch 4 of 12");
    const std::string text = read_progress(path)->text;
    if (std::chrono::steady_clock::now() - started < std::chrono::milliseconds(500)) {
      EXPECT_EQ(text, "epoch 3 of 12") << "written more than twice a second";
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    file.update(6, 12, "epoch 6 of 12");
    // Three epochs took 0.6 s or more, six are to go: twice the time that passed.
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - started;
    EXPECT_GE(read_progress(path)->seconds_left, 1.2);
    EXPECT_LE(read_progress(path)->seconds_left, 2 * passed.count());
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ProgressFile, CannotBeWrittenOrRead) {
  const TemporaryFolder folder("progress_bad");
  ProgressFile file(folder / "absent" / "x.progress");
  EXPECT_NO_THROW(file.update(1, 2, "epoch 1"));
  testing::write_text(folder / "text.progress", "{\"fraction\": ");
  EXPECT_FALSE(read_progress(folder / "text.progress"));
}

}  // namespace
}  // namespace ertbench
