#include "core/process.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/files.h"
#include "core/supervisor.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

std::string text_in(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

ProcessEnd run_shell(const std::string& script, const TemporaryFolder& folder,
                     const ProcessLimits& limits = {60}) {
  return ChildProcess({"sh", "-c", script}, {.log = folder / "log", .folder = folder.path()},
                      limits)
      .wait();
}

bool is_alive(pid_t process) { return process > 0 && ::kill(process, 0) == 0; }

/// Waits until the file holds a process's number and returns that, 0 if it does not come.
pid_t process_in(const fs::path& file) {
  for (int i = 0; i < 500; ++i) {
    const std::string text = text_in(file);
    if (text.ends_with('\n')) return std::atoi(text.c_str());
    std::this_thread::sleep_for(milliseconds(10));
  }
  return 0;
}

TEST(ChildProcess, SaysAllItHasToSayInItsFolder) {
  const TemporaryFolder folder;
  const fs::path log = folder / "log";
  const ProcessEnd end = ChildProcess({"sh", "-c", "echo one; echo two >&2; pwd; exit 3"},
                                      {.log = log, .output = log, .folder = folder.path()}, {60})
                             .wait();
  EXPECT_EQ(end.exit_code, 3);
  EXPECT_EQ(end.text(), "exit code 3");
  EXPECT_EQ(text_in(log), "one\ntwo\n" + folder.path().string() + "\n");
}

TEST(ChildProcess, EndsWithItsTimeAndWhereThereIsNoProgram) {
  const TemporaryFolder folder;
  EXPECT_TRUE(run_shell("sleep 60", folder, {0.05}).timed_out);
  const ProcessEnd end = ChildProcess({"no-such-program"}, {.log = folder / "log"}, {60}).wait();
  EXPECT_EQ(end.exit_code, ChildProcess::not_started);
  EXPECT_EQ(text_in(folder / "log"), "No such file or directory");
  EXPECT_EQ(run_shell("kill -SEGV $$", folder).text(), "Segmentation fault");
}

TEST(ChildProcess, KeepsTheBeginningAndTheEndOfAnEndlessLog) {
  const TemporaryFolder folder;
  const ProcessEnd end =
      run_shell("echo first >&2; head -c 30000000 /dev/zero >&2; echo last >&2", folder);
  EXPECT_TRUE(end.ok());
  const std::string log = text_in(folder / "log");
  EXPECT_LT(log.size(), 2u << 20);
  EXPECT_TRUE(log.starts_with("first\n"));
  EXPECT_TRUE(log.ends_with("last\n"));
  EXPECT_NE(log.find(" bytes left out ..."), std::string::npos);
  EXPECT_TRUE(run_shell("yes x >&2", folder, {0.3}).timed_out);
  EXPECT_LT(fs::file_size(folder / "log"), 2u << 20);
}

TEST(ChildProcess, TakesWhateverItStartedWithIt) {
  const TemporaryFolder folder;
  // One in a session of its own, whose parent is gone; one that ignores what it is told.
  const std::string script =
      "setsid sh -c 'sleep 100 & echo $! > session; exit' &\n"
      "(trap \"\" TERM; sh -c 'echo $$ > deaf; exec sleep 100') &\n"
      "while [ ! -s session -o ! -s deaf ]; do sleep 0.01; done\n";
  EXPECT_TRUE(run_shell(script, folder).ok());
  for (const char* file : {"session", "deaf"}) {
    const pid_t process = process_in(folder / file);
    ASSERT_GT(process, 0) << file;
    EXPECT_FALSE(is_alive(process)) << file;
  }
  EXPECT_TRUE(children_of(::getpid()).empty());
}

TEST(ChildProcess, EndsWithTheProcessThatStartedIt) {
  const TemporaryFolder folder;
  const pid_t parent = ::fork();
  if (parent == 0) {
    ChildProcess child({"sh", "-c", "setsid sleep 100 & echo $! > grandchild; exec sleep 100"},
                       {.log = folder / "log", .folder = folder.path()}, {100});
    child.wait();
    ::_exit(0);
  }
  const pid_t grandchild = process_in(folder / "grandchild");
  ASSERT_TRUE(is_alive(grandchild));
  ::kill(parent, SIGKILL);
  for (int i = 0; i < 500 && is_alive(grandchild); ++i) {
    std::this_thread::sleep_for(milliseconds(10));
  }
  EXPECT_FALSE(is_alive(grandchild));
}

/// Holds that much memory until it is ended.
void hold(std::size_t megabytes) {
  std::vector<char> memory(megabytes << 20, 1);
  std::this_thread::sleep_for(std::chrono::seconds(100));
  ASSERT_EQ(memory.back(), 1);
}

TEST(RunIsolated, EndsWhatTakesTooMuchMemory) {
  const IsolatedOutcome outcome =
      run_isolated([](const auto&) { hold(1000); }, {60, std::uint64_t{600} << 20});
  EXPECT_TRUE(outcome.end.out_of_memory);
  EXPECT_EQ(outcome.end.text(), "out of memory");
}

TEST(RunIsolated, BringsBackMessagesAndKeepsHarmFromItsParent) {
  int value = 1;
  const IsolatedOutcome good = run_isolated(
      [&](const auto& send) {
        value = 2;
        send("one");
        send("");
        send(std::string(300000, 'x'));
      },
      {60});
  EXPECT_TRUE(good.finished);
  EXPECT_EQ(value, 1);
  ASSERT_EQ(good.messages.size(), 3u);
  EXPECT_EQ(good.messages[0], "one");
  EXPECT_EQ(good.messages[2].size(), 300000u);

  const IsolatedOutcome threw = run_isolated([](const auto&) { throw 1; }, {60});
  EXPECT_FALSE(threw.finished);
  EXPECT_EQ(threw.end.exit_code, 1);
  const IsolatedOutcome aborted = run_isolated(
      [](const auto& send) {
        send("so far");
        std::abort();
      },
      {60});
  EXPECT_EQ(aborted.end.signal, SIGABRT);
  EXPECT_EQ(aborted.messages, std::vector<std::string>{"so far"});
}

TEST(RunIsolated, TakesNoExitForAnEnd) {
  const IsolatedOutcome outcome = run_isolated([](const auto&) { std::exit(0); }, {60});
  EXPECT_TRUE(outcome.end.ok());
  EXPECT_FALSE(outcome.finished);
}

TEST(RunIsolated, CountsItsTimeFromTheLastMessage) {
  const auto wait = [] { std::this_thread::sleep_for(milliseconds(300)); };
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        for (int i = 0; i < 4; ++i) {
          wait();
          send("on its way");
        }
        std::this_thread::sleep_for(std::chrono::seconds(100));
      },
      {0.9});
  EXPECT_TRUE(outcome.end.timed_out);
  EXPECT_EQ(outcome.messages.size(), 4u);
}

TEST(ParallelFor, DoesEachItemOnceInPartsThatDoNotDependOnTheThreads) {
  for (const std::size_t count : {0, 1, 7, 1000}) {
    for (const int threads : {0, 1, 3, 16}) {
      std::vector<int> done(count, 0);
      parallel_for(count, 4, threads, [&](std::size_t begin, std::size_t end) {
        EXPECT_EQ(begin % 4, 0U);
        EXPECT_EQ(end, std::min(count, begin + 4));
        for (std::size_t i = begin; i < end; ++i) ++done[i];
      });
      EXPECT_EQ(done, std::vector<int>(count, 1)) << count << " on " << threads;
      std::atomic<std::size_t> parts = 0;
      parallel_for(count, threads, [&](std::size_t begin, std::size_t end) {
        ++parts;
        for (std::size_t i = begin; i < end; ++i) ++done[i];
      });
      EXPECT_EQ(done, std::vector<int>(count, 2)) << count << " on " << threads;
      EXPECT_LE(parts, std::min<std::size_t>(count, std::max(1, threads)));
    }
  }
}

/// Whichever thread is the first to fail, the caller meets the exception of the first item, and no
/// thread is left behind.
TEST(ParallelFor, HandsOnTheExceptionOfTheFirstItemThatFails) {
  for (const int threads : {1, 2, 8}) {
    std::atomic<int> done = 0;
    try {
      parallel_for(100, 1, threads, [&](std::size_t begin, std::size_t) {
        if (begin == 5) std::this_thread::sleep_for(milliseconds(5));
        if (begin >= 5) throw std::runtime_error("item " + std::to_string(begin));
        ++done;
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "item 5");
    }
    EXPECT_EQ(done, 5);
  }
}

}  // namespace
}  // namespace ertbench
