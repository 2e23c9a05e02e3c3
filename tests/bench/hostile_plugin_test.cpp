// The program with plugins that end it, never come back, take all there is or leave processes.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

json with_hostile_solvers(const std::vector<json>& solvers) {
  json experiment = small_experiment();
  experiment["plugins"] = {ERTBENCH_HOSTILE_PLUGIN};
  experiment["time_limit_s"] = 8;
  experiment["solvers"] = json::array({{{"type", "tsvd"}, {"rank", 30}}});
  for (json solver : solvers) {
    solver["type"] = "hostile";
    experiment["solvers"].push_back(solver);
  }
  return experiment;
}

json row_named(const json& summary, const std::string& label) {
  for (const json& row : summary.at("rows")) {
    if (row.at("label") == label) return row;
  }
  return {{"status", "absent"}, {"message", ""}};
}

json run_and_read(const TemporaryFolder& folder, const json& experiment,
                  const std::string& options = "") {
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json --jobs 2 " + options);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_EQ(outcome.output.find('\x1b'), std::string::npos) << outcome.output;
  return json::parse(read_text(folder / "results/small/summary.json"));
}

TEST(HostilePlugin, CostsItsRowAloneWhenItsSolverIsMade) {
  const TemporaryFolder folder("made");
  std::vector<json> solvers;
  for (const char* how : {"exit", "hang", "segv", "throw", "throw-number", "stderr"}) {
    solvers.push_back({{"label", how}, {"how", how}});
  }
  solvers.push_back({{"label", "good"}, {"how", "nothing"}});
  const json summary = run_and_read(folder, with_hostile_solvers(solvers));
  const auto status = [&](const char* label) { return row_named(summary, label).at("status"); };
  EXPECT_EQ(status("tsvd"), "ok");
  EXPECT_EQ(status("good"), "ok");
  EXPECT_EQ(status("exit"), "failed");
  EXPECT_EQ(status("hang"), "timed out");
  EXPECT_EQ(status("segv"), "crashed");
  EXPECT_EQ(status("throw"), "failed");
  EXPECT_EQ(status("throw-number"), "failed");
  EXPECT_EQ(status("stderr"), "timed out");
  EXPECT_EQ(row_named(summary, "exit").at("message"),
            "it ended its process (exit code 0) when it was made to have its parameters checked");
  const std::string thrown = row_named(summary, "throw").at("message");
  EXPECT_NE(thrown.find("on fire"), std::string::npos) << thrown;
}

TEST(HostilePlugin, CostsItsRowAloneInItsTrial) {
  const TemporaryFolder folder("trial");
  std::vector<json> solvers;
  for (const char* how : {"exit", "throw-number", "memory", "stderr"}) {
    solvers.push_back({{"label", how}, {"how", how}, {"when", "fit"}});
  }
  for (const char* how : {"child", "setsid"}) {
    solvers.push_back(
        {{"label", how}, {"how", how}, {"when", "fit"}, {"file", (folder / how).string()}});
  }
  json experiment = with_hostile_solvers(solvers);
  experiment["memory_limit_mb"] = 500;
  const json summary = run_and_read(folder, experiment);
  const auto status = [&](const char* label) { return row_named(summary, label).at("status"); };
  EXPECT_EQ(status("tsvd"), "ok");
  EXPECT_EQ(status("exit"), "failed");
  EXPECT_EQ(row_named(summary, "exit").at("message"), "ended its process before it had a result");
  EXPECT_EQ(status("throw-number"), "crashed");
  EXPECT_EQ(status("memory"), "out of memory");
  EXPECT_EQ(status("stderr"), "timed out");
  EXPECT_LT(fs::file_size(folder / "results/small/records/stderr.accuracy.log"), 2u << 20);
  for (const char* how : {"child", "setsid"}) {
    EXPECT_EQ(status(how), "ok");
    const int process = std::atoi(read_text(folder / how).c_str());
    ASSERT_GT(process, 1) << how;
    EXPECT_NE(::kill(process, 0), 0) << how << " has outlived the trial that left it";
  }
}

TEST(HostilePlugin, IsNotBelievedWhereItsProcessDidNotEndWell) {
  const TemporaryFolder folder("end");
  const json experiment =
      with_hostile_solvers({{{"label", "late"}, {"how", "segv"}, {"when", "end"}}});
  for (int i = 0; i < 2; ++i) {  // nor by the run after
    const json summary = run_and_read(folder, experiment);
    EXPECT_EQ(row_named(summary, "late").at("status"), "crashed");
    EXPECT_TRUE(row_named(summary, "late").at("metrics").at("AR").at("mean").is_null());
    EXPECT_FALSE(fs::exists(folder / "results/small/records/late.accuracy.json"));
  }
}

TEST(HostilePlugin, CostsItsRowsAloneWhenItIsLoaded) {
  for (const std::string how : {"exit", "segv", "throw-number"}) {
    SCOPED_TRACE(how);
    const TemporaryFolder folder("load");
    ::setenv("HOSTILE_LOAD", how.c_str(), 1);
    const json summary =
        run_and_read(folder, with_hostile_solvers({{{"label", "lost"}, {"how", "nothing"}}}));
    ::unsetenv("HOSTILE_LOAD");
    EXPECT_EQ(row_named(summary, "tsvd").at("status"), "ok");
    EXPECT_EQ(row_named(summary, "lost").at("status"), "failed");
    const std::string message = row_named(summary, "lost").at("message");
    EXPECT_NE(message.find("when it was loaded"), std::string::npos) << message;
  }
}

TEST(HostilePlugin, CannotEndReconstructUnseen) {
  const TemporaryFolder folder("reconstruct");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "generate small.json --dataset test --out t.h5").exit_code,
            0);
  for (const std::string how : {"exit", "segv"}) {
    write_text(folder / "s.json", json{{"type", "hostile"}, {"how", how}}.dump());
    const Outcome outcome = run_program(
        folder.path(), "reconstruct --solver s.json --input t.h5 --output o.h5 --plugin " +
                           std::string(ERTBENCH_HOSTILE_PLUGIN));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_NE(outcome.output.find("the solver ended its process"), std::string::npos)
        << outcome.output;
    EXPECT_FALSE(fs::exists(folder / "o.h5"));
  }
  // An exception of its own is no defect of the program.
  write_text(folder / "s.json", json{{"type", "hostile"}, {"how", "throw"}}.dump());
  for (const char* command :
       {"reconstruct --output o.h5 --input t.h5", "live --input replay:t.h5"}) {
    const Outcome outcome =
        run_program(folder.path(),
                    command + std::string(" --solver s.json --plugin ") + ERTBENCH_HOSTILE_PLUGIN);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_NE(outcome.output.find(ERTBENCH_HOSTILE_PLUGIN ": its solver \"hostile\" threw"),
              std::string::npos)
        << outcome.output;
  }
  ASSERT_EQ(::mkfifo((folder / "pipe.so").c_str(), 0600), 0);
  const Outcome pipe = run_program(
      folder.path(), "reconstruct --solver s.json --input t.h5 --output o.h5 --plugin pipe.so");
  EXPECT_EQ(pipe.exit_code, 2) << pipe.output;
  EXPECT_NE(pipe.output.find("name a regular file"), std::string::npos) << pipe.output;
}

TEST(HostilePlugin, EndsWithTheReconstructThatIsTerminated) {
  const TemporaryFolder folder("terminated");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "generate small.json --dataset test --out t.h5").exit_code,
            0);
  const json solver = {{"type", "hostile"},
                       {"how", "hang"},
                       {"when", "fit"},
                       {"file", (folder / "process").string()}};
  write_text(folder / "s.json", solver.dump());
  const pid_t program = ::fork();
  if (program == 0) {
    const std::string command =
        "cd " + quoted(folder.path().string()) + " && exec " + quoted(ERTBENCH_PROGRAM) +
        " reconstruct --solver s.json --input t.h5 --output o.h5 --plugin " +
        quoted(ERTBENCH_HOSTILE_PLUGIN) + " >log 2>&1";
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(127);
  }
  const auto wait_for = [](const std::function<bool()>& come) {
    for (int i = 0; i < 1000 && !come(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return come();
  };
  ASSERT_TRUE(wait_for([&] { return read_text(folder / "process").ends_with("\n"); }));
  const int left = std::atoi(read_text(folder / "process").c_str());
  ASSERT_EQ(::kill(left, 0), 0);
  ::kill(program, SIGTERM);
  ::waitpid(program, nullptr, 0);
  EXPECT_TRUE(wait_for([&] { return ::kill(left, 0) != 0; })) << "it has outlived the program";
  EXPECT_FALSE(fs::exists(folder / "o.h5"));
}

}  // namespace
}  // namespace ertbench
