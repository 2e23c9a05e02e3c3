// What the command line says and takes: options, suggestions, versions, lists, the cache.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/record/cache.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

bool says(const Outcome& outcome, const std::string& text) {
  return outcome.output.find(text) != std::string::npos;
}

TEST(CommandLine, ARunSaysHowItIsMadeAgain) {
  const TemporaryFolder folder("again");
  write_text(folder / "small.json", small_experiment().dump());
  // The experiment may stand behind an option that takes several values.
  const std::string arguments = "--set datasets.test.count=12 --only tsvd small.json --out D";
  const Outcome outcome = run_program(folder.path(), "run " + arguments);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json summary = summary_of(folder / "D");
  const std::string command =
      "./ertbench run small.json --set datasets.test.count=12 --only tsvd --out D";
  EXPECT_EQ(summary.at("command"), command);
  EXPECT_EQ(summary.at("set"), json({"datasets.test.count=12"}));
  EXPECT_EQ(row_of(summary, "tsvd").at("frames"), 12);
  EXPECT_NE(read_text(folder / "D/report.html").find(command), std::string::npos);
  // The same command again makes nothing anew, and the date stays that of the measurement.
  const Outcome again =
      run_program(folder.path(), command.substr(std::string("./ertbench ").size()));
  ASSERT_EQ(again.exit_code, 0) << again.output;
  const json second = summary_of(folder / "D");
  EXPECT_EQ(second.at("provenance").at("date"), summary.at("provenance").at("date"));
  EXPECT_EQ(second.at("provenance").at("measured"), summary.at("provenance").at("measured"));
  EXPECT_EQ(second.at("rows"), summary.at("rows"));
}

TEST(CommandLine, EntriesWithoutLabelsAreNumbered) {
  const TemporaryFolder folder("numbered");
  json experiment = small_experiment();
  experiment["solvers"] = json::parse(
      R"([{"type": "tsvd", "rank": 30}, {"type": "tsvd", "rank": 20}, {"type": "tsvd", "rank": 9}])");
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json --out D");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json summary = summary_of(folder / "D");
  EXPECT_EQ(row_of(summary, "tsvd").at("parameters").at("rank"), 30);
  EXPECT_EQ(row_of(summary, "tsvd-2").at("parameters").at("rank"), 20);
  EXPECT_EQ(row_of(summary, "tsvd-3").at("parameters").at("rank"), 9);
}

// Clocks are compared where they were read in one go: a row that comes later takes all with it.
TEST(CommandLine, RowsAreTimedTogether) {
  const TemporaryFolder folder("together");
  json experiment = small_experiment();
  experiment["timing"] = {{"frames", 662}, {"batch", 8}, {"rounds", 2}};
  write_text(folder / "small.json", experiment.dump());
  const auto run = [&](const std::string& more) {
    const Outcome outcome = run_program(folder.path(), "run small.json --out D" + more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return outcome;
  };
  const auto record = [&](const std::string& label) {
    return read_text(folder / "D/records" / (label + ".timing.0.json"));
  };
  run(" --only tsvd");
  const std::string alone = record("tsvd");
  const json row = row_of(summary_of(folder / "D"), "tsvd");
  EXPECT_FALSE(row.at("timed_on").at("cpu").get<std::string>().empty());
  EXPECT_GE(row.at("timed_on").at("busy_cores"), 0);
  const Outcome all = run("");
  EXPECT_TRUE(says(all, "all others are made again")) << all.output;
  const std::string together = record("tsvd");
  EXPECT_NE(together, alone);
  run("");
  EXPECT_EQ(record("tsvd"), together);
  fs::remove(folder / "D/records/pdipm.timing.1.json");
  run(" --only pdipm");
  EXPECT_NE(record("tsvd"), together);
}

TEST(CommandLine, SuggestsWhatMayBeMeant) {
  const TemporaryFolder folder("suggestions");
  const auto answer = [&](const std::string& arguments) {
    const Outcome outcome = run_program(folder.path(), arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    return outcome;
  };
  EXPECT_TRUE(says(answer("run small.json --onyl tsvd"), "Did you mean --only?"));
  EXPECT_TRUE(says(answer("rnu small.json"), "did you mean \"run\"?"));
  EXPECT_TRUE(says(answer("list tvsd"), "did you mean \"tsvd\"?"));
  EXPECT_TRUE(says(answer("cache --prune"), "--stale, --older-than DAYS, or --all"));
  EXPECT_TRUE(says(answer("cache --prune --older-than nan"), "must be a finite number"));
  EXPECT_TRUE(says(answer("run ''"), "must not be empty"));
}

TEST(CommandLine, SaysItsVersionAndListsForPrograms) {
  const TemporaryFolder folder("lists");
  const Outcome version = run_program(folder.path(), "--version");
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_EQ(version.output.rfind("ertbench ", 0), 0u) << version.output;
  EXPECT_TRUE(says(version, ".") && says(version, "(commit ")) << version.output;
  const Outcome one = run_program(folder.path(), "list tsvd");
  EXPECT_TRUE(says(one, "\"rank\"")) << one.output;
  EXPECT_FALSE(says(one, "pdipm")) << one.output;
  const Outcome all = run_program(folder.path(), "list --json");
  ASSERT_EQ(all.exit_code, 0) << all.output;
  const json listed = json::parse(all.output);
  EXPECT_FALSE(listed.at("metrics").empty());
  EXPECT_FALSE(listed.at("experiments").empty());
  bool found = false;
  for (const json& solver : listed.at("solvers")) {
    if (solver.at("type") == "tsvd") found = !solver.at("parameters").empty();
  }
  EXPECT_TRUE(found);
}

// A built tree may be moved: neither the program nor its libraries name the folder of the build.
TEST(CommandLine, ABuiltTreeCanBeMoved) {
  const TemporaryFolder folder("moved");
  const fs::path program = ERTBENCH_PROGRAM;
  const fs::path build = program.parent_path().parent_path();
  fs::create_directories(folder / "experiments");
  for (const char* name : {"schema.json", "quick.json"}) {
    fs::copy_file(ERTBENCH_SOURCE_DIR "/experiments/" + std::string(name),
                  folder / "experiments" / name);
  }
  for (const char* room : {"bench", "core", "forward", "solvers"}) {
    const fs::path moved = folder / "build" / "any" / room;
    fs::create_directories(moved);
    for (const auto& entry : fs::directory_iterator(build / room)) {
      const bool library = entry.path().extension() == ".so";
      if (library || entry.path() == program) {
        fs::copy_file(entry.path(), moved / entry.path().filename());
      }
    }
  }
  write_text(folder / "experiments/unusable.json", R"({"solvers": 1})");
  const fs::path moved = folder / "build/any/bench" / program.filename();
  const Outcome list = run_program(folder.path(), "list", moved);
  ASSERT_EQ(list.exit_code, 0) << list.output;
  EXPECT_TRUE(says(list, "experiments/quick.json")) << list.output;
  EXPECT_FALSE(says(list, "experiments/table_c1.json")) << list.output;  // of the other folder
  // One that cannot be used is listed as such, and the others beside it.
  EXPECT_TRUE(says(list, "experiments/unusable.json\n      cannot be used: ")) << list.output;
  EXPECT_EQ(read_text(moved).find(build.string() + "/core"), std::string::npos);
}

TEST(CommandLine, TheCacheIsListedAndPruned) {
  const TemporaryFolder folder("cache");
  EXPECT_TRUE(says(run_program(folder.path(), "cache"), "0 datasets and solvers"));
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json --out D").exit_code, 0);
  EXPECT_TRUE(says(run_program(folder.path(), "cache"), "5 datasets and solvers"));
  const Outcome none = run_program(folder.path(), "cache --prune --stale --older-than 1");
  EXPECT_TRUE(says(none, "0 datasets and solvers removed")) << none.output;
  write_text(folder / "cache/datasets/thesis.h5", "mine");
  fs::create_directories(folder / "cache/solvers/my.fitted");
  const Outcome would = run_program(folder.path(), "cache --prune --all --dry-run");
  EXPECT_TRUE(says(would, "5 datasets and solvers would be removed")) << would.output;
  {
    const CacheShare run(Cache(folder / "cache"), CacheShare::Of::run);
    const Outcome refused = run_program(folder.path(), "cache --prune --all");
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_TRUE(says(refused, "a run needs what it holds; wait for its end")) << refused.output;
    EXPECT_TRUE(says(run_program(folder.path(), "cache"), "5 datasets and solvers"));
  }
  EXPECT_TRUE(
      says(run_program(folder.path(), "cache --prune --all"), "5 datasets and solvers removed"));
  // What the program did not write stays.
  EXPECT_TRUE(fs::remove(folder / "cache/datasets/thesis.h5"));
  EXPECT_TRUE(fs::remove(folder / "cache/solvers/my.fitted"));
  EXPECT_TRUE(fs::is_empty(folder / "cache/datasets"));
  EXPECT_TRUE(fs::is_empty(folder / "cache/solvers"));
  // What was removed is made again.
  fs::remove_all(folder / "D");
  EXPECT_EQ(run_program(folder.path(), "run small.json --out D").exit_code, 0);
}

}  // namespace
}  // namespace ertbench
