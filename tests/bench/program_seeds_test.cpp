// Training seeds, sweeps, fit reports and progress, through the program.

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// The small experiment with one toy network of three seeds.
json toy_experiment(const json& more = json::object()) {
  json experiment = small_experiment();
  experiment["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  json entry = {{"type", "toy-learned"}, {"label", "net"}, {"seeds", {1, 2, 3}}};
  entry.update(more);
  experiment["solvers"] = json::array({entry});
  return experiment;
}

std::set<std::string> names_in(const fs::path& folder, const std::string& ending) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(ending)) names.insert(name);
  }
  return names;
}

TEST(ProgramSeeds, EachSeedIsATrialAndTheRowIsTheirMean) {
  const TemporaryFolder folder("seeds");
  json experiment = toy_experiment();
  experiment["timing"] = {{"frames", 662}, {"batch", 8}, {"rounds", 2}};
  write_text(folder / "toy.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run toy.json --jobs 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const fs::path results = folder / "results/toy";
  EXPECT_EQ(names_in(results / "records", ".json"),
            (std::set<std::string>{"net.seed1.accuracy.json", "net.seed2.accuracy.json",
                                   "net.seed3.accuracy.json", "net.seed1.timing.0.json",
                                   "net.seed1.timing.1.json"}));
  EXPECT_EQ(names_in(folder / "cache/solvers", ".fitted").size(), 3u);
  const json summary = summary_of(results);
  EXPECT_EQ(summary.at("rows").size(), 3u);  // with truth and no-contact
  const json& row = row_of(summary, "net");
  EXPECT_EQ(row.at("status"), "ok");
  EXPECT_EQ(row.at("frames"), 40);
  EXPECT_GT(row.at("latency_us").at("p50"), 0);
  const json& seeds = row.at("seeds");
  EXPECT_EQ(seeds.at("values"), json({1, 2, 3}));
  // The image is the seed times a constant and AR is linear in it.
  const auto ar = seeds.at("means").at("AR").get<std::vector<double>>();
  EXPECT_NEAR(ar[1], 2 * ar[0], 1e-12);
  EXPECT_NEAR(ar[2], 3 * ar[0], 1e-12);
  EXPECT_NEAR(row.at("metrics").at("AR").at("mean"), ar[1], 1e-12);
  EXPECT_NEAR(seeds.at("deviation").at("AR"), std::abs(ar[0]), 1e-12);
  EXPECT_EQ(row.at("parameters").at("seed"), 1);
  EXPECT_EQ(seeds.at("parameters")[2].at("seed"), 3);
  EXPECT_FALSE(seeds.at("parameters")[2].contains("level"));
  for (const char* table : {"table.md", "table.tex", "table.csv"}) {
    EXPECT_NE(read_text(results / table).find("seeds"), std::string::npos) << table;
  }
  EXPECT_NE(outcome.output.find("over 3 seeds"), std::string::npos) << outcome.output;
}

TEST(ProgramSeeds, AnEntryWithOneSeedSharesTheFittedFile) {
  const TemporaryFolder folder("seed_cache");
  write_text(folder / "toy.json", toy_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "run toy.json").exit_code, 0);
  const auto fitted = names_in(folder / "cache/solvers", ".fitted");
  json alone = toy_experiment();
  alone["solvers"] = json::array({{{"type", "toy-learned"}, {"seed", 2}}});
  write_text(folder / "alone.json", alone.dump());
  ASSERT_EQ(run_program(folder.path(), "run alone.json").exit_code, 0);
  EXPECT_EQ(names_in(folder / "cache/solvers", ".fitted"), fitted);
  EXPECT_FALSE(row_of(summary_of(folder / "results/alone"), "toy-learned").contains("seeds"));
}

TEST(ProgramSeeds, TwoRunsAtOnceFitTheSameSolverOnce) {
  const TemporaryFolder folder("two_runs");
  json toy = toy_experiment({{"epoch_s", 0.1}});
  toy["solvers"][0]["seeds"] = {1};
  write_text(folder / "toy.json", toy.dump());
  std::thread other([&] { run_program(folder.path(), "run toy.json --only net --out other"); });
  const Outcome outcome = run_program(folder.path(), "run toy.json --only net --out one");
  other.join();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(read_text(folder / "cache/solvers/fits"), "fit\n");
}

TEST(ProgramSeeds, AFailingSeedCostsNoOther) {
  const TemporaryFolder folder("seed_fails");
  write_text(folder / "toy.json", toy_experiment({{"bad_seed", 2}}).dump());
  const Outcome outcome = run_program(folder.path(), "run toy.json --only net");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  const json row = row_of(summary_of(folder / "results/toy"), "net");
  EXPECT_EQ(row.at("status"), "crashed");
  const std::string message = row.at("message");
  EXPECT_EQ(message.rfind("seed 2: ", 0), 0u) << message;
  EXPECT_NE(message.find("; the numbers are of the other 2 seeds"), std::string::npos) << message;
  EXPECT_EQ(row.at("seeds").at("values"), json({1, 3}));
  EXPECT_NE(outcome.output.find("net seed 2 (accuracy): crashed"), std::string::npos);
}

TEST(ProgramSeeds, AFitThatReportsTroubleKeepsItsNumbersAndIsNoFailure) {
  const TemporaryFolder folder("diverged");
  write_text(folder / "toy.json", toy_experiment({{"bad_seed", 3}, {"how", "diverge"}}).dump());
  const Outcome outcome = run_program(folder.path(), "run toy.json");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const json row = row_of(summary_of(folder / "results/toy"), "net");
  EXPECT_EQ(row.at("status"), "diverged");
  EXPECT_EQ(row.at("message"), "seed 3: the loss rose to infinity");
  EXPECT_EQ(row.at("seeds").at("values"), json({1, 2, 3}));
  EXPECT_TRUE(row.at("metrics").at("AR").at("mean").is_number());
}

TEST(ProgramSeeds, FramesUndefinedForOneSeedAreCounted) {
  const TemporaryFolder folder("undefined");
  write_text(folder / "toy.json", toy_experiment({{"bad_seed", 2}, {"how", "undefined"}}).dump());
  ASSERT_EQ(run_program(folder.path(), "run toy.json").exit_code, 0);
  const json row = row_of(summary_of(folder / "results/toy"), "net");
  EXPECT_EQ(row.at("undefined_frames"), 1);  // the first of one block of frames
  EXPECT_EQ(row.at("metrics").at("AR").at("undefined"), 1);
  EXPECT_EQ(row.at("metrics").at("AR").at("count"), 39);
}

TEST(ProgramSeeds, SweepMakesARowOfEachCombination) {
  const TemporaryFolder folder("sweep");
  json experiment = toy_experiment({{"seeds", {4, 5}}});
  experiment["solvers"][0]["sweep"] = {{"level", {-1e-4, -1e-3}}, {"offset", {0, 0.5}}};
  experiment["solvers"].push_back({{"type", "tsvd"}, {"rank", 30}});
  write_text(folder / "toy.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run toy.json --only net");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json summary = summary_of(folder / "results/toy");
  std::vector<std::string> labels;
  for (const json& row : summary.at("rows")) labels.push_back(row.at("label"));
  EXPECT_EQ(labels,
            (std::vector<std::string>{"truth", "no-contact", "net level=-0.0001 offset=0",
                                      "net level=-0.0001 offset=0.5", "net level=-0.001 offset=0",
                                      "net level=-0.001 offset=0.5", "tsvd"}));
  const json& row = row_of(summary, "net level=-0.001 offset=0.5");
  EXPECT_EQ(row.at("sweep"), json({{"level", -1e-3}, {"offset", 0.5}}));
  EXPECT_EQ(row.at("parameters").at("offset"), 0.5);
  EXPECT_EQ(row.at("seeds").at("values"), json({4, 5}));
  EXPECT_EQ(row_of(summary, "tsvd").at("status"), "not run");
}

TEST(ProgramSeeds, ChartsAndTrainingLogsAreAmongTheResults) {
  const TemporaryFolder folder("charts");
  json experiment = toy_experiment({{"seeds", {1, 2}}});
  experiment["solvers"][0]["sweep"] = {{"level", {-1e-4, -1e-3}}, {"offset", {0, -0.5}}};
  experiment["solvers"].push_back({{"type", "tsvd"}, {"rank", 30}});
  experiment["charts"] = json::parse(R"([
      {"type": "bars", "name": "variants", "solvers": ["tsvd", "net"], "metrics": ["AR", "PE"]},
      {"type": "heat-map", "name": "grid", "solver": "net", "published_optimum": [-1e-4, 0]}])");
  write_text(folder / "toy.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run toy.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const fs::path results = folder / "results/toy";
  const std::string bars = read_text(results / "variants.svg");
  EXPECT_NE(bars.find("tsvd"), std::string::npos);
  const std::string map = read_text(results / "grid.svg");
  EXPECT_NE(map.find("choice: level = -0.0001, offset = 0<"), std::string::npos);
  EXPECT_NE(map.find("best here: "), std::string::npos);
  EXPECT_GT(fs::file_size(results / "grid.png"), 500u);
  const std::string label = "net level=-0.001 offset=-0.5";
  EXPECT_EQ(read_text(results / "training" / (label + ".seed2.csv")).rfind("epoch,loss,content", 0),
            0u);
  const std::string training = read_text(results / "training" / (label + ".svg"));
  for (const char* word : {">content<", ">epoch kept<", "seed 1, seed 2"}) {
    EXPECT_NE(training.find(word), std::string::npos) << word;
  }
  EXPECT_FALSE(fs::exists(results / "training/tsvd.svg"));
}

TEST(ProgramSeeds, TellsHowTrainingGetsOn) {
  const TemporaryFolder folder("progress_bar");
  write_text(folder / "toy.json",
             toy_experiment({{"seeds", {7}}, {"epochs", 30}, {"epoch_s", 0.1}}).dump());
  // On a terminal of its own.
  int terminal = -1;
  winsize size{24, 100, 0, 0};
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, &size);
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::chdir(folder.path().c_str());
    ::setenv("ERTBENCH_CACHE", (folder / "cache").c_str(), 1);
    ::execl(ERTBENCH_PROGRAM, ERTBENCH_PROGRAM, "run", "toy.json", nullptr);
    ::_exit(127);
  }
  std::string shown;
  char buffer[4096];
  while (true) {
    const ssize_t n = ::read(terminal, buffer, sizeof buffer);
    if (n <= 0) break;  // also EIO, where the other side is closed
    shown.append(buffer, static_cast<std::size_t>(n));
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::close(terminal);
  EXPECT_EQ(status, 0) << shown;
  EXPECT_NE(shown.find("accuracy of 1 trial ["), std::string::npos) << shown;
  EXPECT_NE(shown.find("%: net seed 7 epoch "), std::string::npos) << shown;
  EXPECT_NE(shown.find(" left"), std::string::npos) << shown;
  EXPECT_TRUE(names_in(folder / "results/toy/records", ".progress").empty());
}

}  // namespace
}  // namespace ertbench
