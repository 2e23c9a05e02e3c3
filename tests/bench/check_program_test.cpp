// `ertbench check` as users call it: baselines made, kept and broken.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "tests/bench/checked_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

TEST(CheckProgram, NamesTheRowThatASolverBrokenOnPurposeMakesWorse) {
  CheckedExperiment small("broken");
  Outcome outcome = small.check("--update");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "Baseline of 4 rows in small.baseline")) << outcome.output;
  outcome = small.check();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok; weakest: ")) << outcome.output;

  small.rebuild("0.25");
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "3 rows ok, 1 worse")) << outcome.output;
  const std::string page = read_text(small.folder() / "results/small/check/check.md");
  const std::regex worse(R"(\| toy +\| relative_error +\|[^\n]*\| worse +\|)");
  EXPECT_TRUE(std::regex_search(page, worse)) << page;

  small.rebuild("0.75");  // nearer to the mean of the truth
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "3 rows ok, 1 better")) << outcome.output;
  outcome = small.check("--update");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "better")) << outcome.output;
  outcome = small.check("--all");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok")) << outcome.output;
  EXPECT_TRUE(contains(outcome, "1e-08 (")) << outcome.output;
}

TEST(CheckProgram, MakesAnewWhatAnotherBuildLeftAndKeepsItsOwn) {
  CheckedExperiment small("builds");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  ::setenv("TOY_GAIN", "0.25", 1);  // of which the bytes of program and plugin know nothing
  EXPECT_EQ(small.check().exit_code, 0);
  small.rebuild("0.25");
  EXPECT_EQ(small.check().exit_code, 1);
}

TEST(CheckProgram, ARowThatTheBaselineLostIsMissing) {
  CheckedExperiment small("lost");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  json lost = small.baseline();
  lost["rows"].erase(3);  // the toy's
  small.set_baseline(lost);
  const Outcome outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "3 rows ok, 1 missing")) << outcome.output;
}

TEST(CheckProgram, EmptiesOnlyFoldersThatItHasMarked) {
  CheckedExperiment small("foreign");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  const fs::path mine = small.folder() / "mine";
  for (const char* folder : {"cache", "records", "seeds"}) {
    fs::create_directories(mine / folder);
    write_text(mine / folder / "precious", "text");
  }
  const auto left_alone = [&] {
    const Outcome outcome = small.check("--out mine");
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_TRUE(contains(outcome, "mine: holds results that are not a check's")) << outcome.output;
    for (const char* folder : {"cache", "records", "seeds"}) {
      EXPECT_EQ(read_text(mine / folder / "precious"), "text");
    }
  };
  left_alone();
  write_text(mine / "program", "of somebody's");
  left_alone();
  write_text(mine / ".ertbench-check", "text");
  left_alone();
  write_text(mine / ".ertbench-check", R"({"made_by": "me", "program": "0"})");
  left_alone();
  fs::remove(mine / ".ertbench-check");
  fs::create_symlink(small.folder() / "results/small/check/.ertbench-check",
                     mine / ".ertbench-check");
  left_alone();
}

TEST(CheckProgram, LeavesTheResultsOfARunAloneAndCanReuseThem) {
  CheckedExperiment small("reuse");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  ASSERT_EQ(run_program(small.folder().path(), "run small.json").exit_code, 0);
  const Outcome refused = small.check("--out results/small");
  EXPECT_EQ(refused.exit_code, 2) << refused.output;
  EXPECT_TRUE(contains(refused, "results/small: holds results that are not a check's"))
      << refused.output;
  EXPECT_TRUE(fs::exists(small.folder() / "results/small/records/toy.accuracy.json"));
  const Outcome reused = small.check("--reuse");
  EXPECT_EQ(reused.exit_code, 0) << reused.output;
  EXPECT_TRUE(fs::exists(small.folder() / "results/small/check.md"));
}

TEST(CheckProgram, WithoutAUsableBaselineItSaysHowToMakeOneBeforeItRunsAnything) {
  CheckedExperiment small("unusable");
  const auto refused = [&](const std::string& message) {
    fs::remove_all(small.folder() / "results");
    const Outcome outcome = small.check();
    EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
    EXPECT_TRUE(contains(outcome, message)) << outcome.output;
    EXPECT_TRUE(contains(outcome, "`ertbench check small.json --update`")) << outcome.output;
    EXPECT_FALSE(fs::exists(small.folder() / "results"));
  };
  refused("small.baseline: there is no baseline");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  const json good = small.baseline();

  json bad = good;
  bad["rows"][2].erase("frames");
  small.set_baseline(bad);
  refused("small.baseline: /rows/2/frames: is missing");
  bad = good;
  bad["rows"] = json::array();
  small.set_baseline(bad);
  refused("small.baseline: /rows: holds no rows");
  bad = good;
  bad["rows"][2]["metrics"]["AR"] = 1;
  write_text(small.folder() / "small.baseline", bad.dump());
  refused("small.baseline: /checksum: is not that of the content");
  write_text(small.folder() / "small.baseline", R"({"schema": 1,)");
  refused("small.baseline: not valid JSON");
  small.set_baseline(good);

  small.experiment["datasets"]["test"]["count"] = 30;
  refused("made of another experiment: /datasets/test/count was 40 and is 30 in small.json");
  small.experiment["datasets"]["test"]["count"] = 40;
  small.experiment["solvers"][0]["rank"] = 25;
  refused("the entry of tsvd, /rank was 30 and is 25 in small.json");
  const Outcome update = small.check("--update");
  EXPECT_EQ(update.exit_code, 0) << update.output;
  EXPECT_TRUE(contains(update, "Made anew: small.baseline: was made of another experiment"))
      << update.output;
  EXPECT_EQ(small.check().exit_code, 0);
}

TEST(CheckProgram, ATrainedRowIsHeldToTheSpreadOfItsSeeds) {
  CheckedExperiment small("seeds");
  small.experiment["solvers"] = {{{"type", "toy-learned"}, {"label", "net"}, {"seed", 3}},
                                 {{"type", "tsvd"}, {"rank", 30}}};
  const Outcome refused = small.check("--update --seeds 4");
  EXPECT_EQ(refused.exit_code, 1) << refused.output;
  EXPECT_TRUE(contains(refused, "net AR only from ")) << refused.output;
  EXPECT_TRUE(contains(refused, "Raise /check/seeds or /check/baseline_seeds in small.json"))
      << refused.output;
  EXPECT_FALSE(fs::exists(small.folder() / "small.baseline"));
  ASSERT_EQ(small.check("--update --accept-coarse --seeds 4").exit_code, 0);
  const json row = row_of(small.baseline(), "net");
  EXPECT_EQ(row.at("seeds"), json({3, 1, 2, 4}));
  EXPECT_EQ(row.at("tolerance").at("class"), "seeds");
  EXPECT_FALSE(row.at("entry").contains("seed"));
  // The image is the seed times a constant, and so is AR.
  const auto ar = row.at("metrics").at("AR").get<std::vector<double>>();
  EXPECT_NEAR(ar[0], 3 * ar[1], 1e-12);
  EXPECT_TRUE(row_of(small.baseline(), "tsvd").at("metrics").at("AR").is_number());
  EXPECT_EQ(small.check().exit_code, 0);
  small.experiment["solvers"][0]["seed"] = 6;  // any seed will do
  EXPECT_EQ(small.check().exit_code, 0);
  // Mean 2.5, deviation 1.29, t(0.9995, 3) = 12.92: 2.5 +- 18.7, in units of what seed 1 has.
  small.rebuild("0.5");  // 3
  EXPECT_EQ(small.check().exit_code, 0);
  small.rebuild("-3");  // -18
  const Outcome outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "net         AR")) << outcome.output;

  // The check trains as many seeds as the experiment says: the mean of 6, 1 and 2 is 3, and the
  // interval +- 12.92 1.29 sqrt(1/3 + 1/4) = 12.7.
  small.experiment["check"] = {{"seeds", 3}};
  small.rebuild("0.5");  // 1.5
  EXPECT_EQ(small.check().exit_code, 0);
  small.rebuild("-4");  // -12
  EXPECT_EQ(small.check().exit_code, 1);
  EXPECT_TRUE(fs::exists(small.folder() / "results/small/check/seeds/summary.json"));
  small.experiment["check"] = {{"baseline_seeds", 6}};
  ASSERT_EQ(small.check("--update --accept-coarse").exit_code, 0);
  EXPECT_EQ(row_of(small.baseline(), "net").at("seeds"), json({6, 1, 2, 3, 4, 5}));
  small.experiment.erase("check");

  // An experiment that lists seeds has its spread already.
  small.rebuild("1");
  small.experiment["solvers"][0].erase("seed");
  small.experiment["solvers"][0]["seeds"] = {1, 2, 3, 4, 5};
  fs::remove_all(small.folder() / "results");
  ASSERT_EQ(small.check("--update --accept-coarse").exit_code, 0);
  EXPECT_EQ(row_of(small.baseline(), "net").at("seeds"), json({1, 2, 3, 4, 5}));
  EXPECT_FALSE(fs::exists(small.folder() / "results/small/check/seeds"));
}

TEST(CheckProgram, TrainsOverSeedsWhatAnExperimentExtends) {
  CheckedExperiment small("extends");
  small.experiment["solvers"][0] = {{"type", "toy-learned"}, {"label", "net"}};
  write_text(small.folder() / "base.json", small.experiment.dump());
  small.experiment = {{"extends", "base.json"}, {"check", {{"baseline_seeds", 3}}}};
  const Outcome outcome = small.check("--update --accept-coarse");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(row_of(small.baseline(), "net").at("seeds"), json({1, 2, 3}));
}

TEST(CheckProgram, AFailedTrialIsWorseAndNoBaseline) {
  CheckedExperiment small("failed");
  small.experiment["solvers"] = {
      {{"type", "tsvd"}, {"rank", 30}},
      {{"type", "toy-learned"}, {"seeds", {1, 2, 3}}, {"label", "net"}, {"how", "crash"}}};
  ASSERT_EQ(small.check("--update --accept-coarse --seeds 3").exit_code, 0);
  const json good = small.baseline();
  small.experiment["solvers"][1]["bad_seed"] = 2;
  const Outcome update = small.check("--update");
  EXPECT_EQ(update.exit_code, 1) << update.output;
  EXPECT_TRUE(contains(update, "a trial failed, so that the baseline was left as it is"))
      << update.output;
  EXPECT_EQ(small.baseline(), good);
  json same_entry = good;
  for (json& row : same_entry["rows"]) {
    if (row["label"] == "net") row["entry"]["bad_seed"] = 2;
  }
  small.set_baseline(same_entry);
  const Outcome outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "crashed: seed 2: ")) << outcome.output;
  EXPECT_TRUE(contains(outcome, "3 rows ok, 1 worse")) << outcome.output;
}

TEST(CheckProgram, ASlowDownCountsOnTheSameCpuAlone) {
  CheckedExperiment small("times");
  small.experiment["solvers"] = {{{"type", "misbehaving"}, {"how", "gain"}, {"label", "toy"}}};
  small.experiment["timing"] = {{"frames", 662}, {"batch", 8}, {"rounds", 2}};
  ASSERT_EQ(small.check("--update").exit_code, 0);
  json faster = small.baseline();
  json& times = faster["rows"].back()["times"];
  ASSERT_GT(times.at("latency"), 0);
  ASSERT_GT(times.at("batch_frame"), 0);
  EXPECT_TRUE(faster["rows"][0]["times"].is_null());  // the truth
  times["latency"] = 1e-3 * times.at("latency").get<double>();
  small.set_baseline(faster);
  Outcome outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "2 rows ok, 1 slower;")) << outcome.output;
  faster["provenance"]["cpu"] = "another";
  small.set_baseline(faster);
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "2 rows ok, 1 slower (warning);")) << outcome.output;
  EXPECT_TRUE(contains(outcome, "timed on another cpu")) << outcome.output;
}

}  // namespace
}  // namespace ertbench
