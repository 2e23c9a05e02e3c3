// `ertbench check` as users call it: baselines made, kept and broken.

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/hdf5_file.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// A folder with an experiment of its own copy of the toy solvers, so that they can be "rebuilt".
class CheckedExperiment {
 public:
  explicit CheckedExperiment(const std::string& name) : folder_("check_" + name) {
    fs::copy_file(ERTBENCH_MISBEHAVING_PLUGIN, folder_ / "libtoys.so");
    experiment = small_experiment();
    experiment["plugins"] = {"libtoys.so"};
    experiment["figure"] = {{"scenes", json::array()}};
    experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}},
                             {{"type", "misbehaving"}, {"how", "gain"}, {"label", "toy"}}};
  }
  ~CheckedExperiment() { ::unsetenv("TOY_GAIN"); }

  Outcome check(const std::string& options = "") {
    write_text(folder_ / "small.json", experiment.dump());
    return run_program(folder_.path(), "check small.json --baseline small.baseline " + options);
  }
  /// Gives the toy solvers another gain, and their library other bytes.
  void rebuild(const char* gain) {
    ::setenv("TOY_GAIN", gain, 1);
    write_text(folder_ / "libtoys.so", read_text(folder_ / "libtoys.so") + "\n");
  }
  json baseline() const { return json::parse(read_text(folder_ / "small.baseline")); }
  void set_baseline(const json& changed) {
    write_text(folder_ / "small.baseline", changed.dump(2));
  }
  const TemporaryFolder& folder() const { return folder_; }

  json experiment;

 private:
  TemporaryFolder folder_;
};

bool contains(const Outcome& outcome, const std::string& text) {
  return outcome.output.find(text) != std::string::npos;
}

TEST(CheckProgram, NamesTheRowThatASolverBrokenOnPurposeMakesWorse) {
  CheckedExperiment small("broken");
  Outcome outcome = small.check("--update");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "Baseline of 4 rows in small.baseline")) << outcome.output;
  outcome = small.check();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok; all of it in results/small/check/check.md"))
      << outcome.output;

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
  EXPECT_TRUE(contains(outcome, "± 1e-08")) << outcome.output;
}

TEST(CheckProgram, MakesAnewWhatAnotherBuildLeftAndKeepsItsOwn) {
  CheckedExperiment small("builds");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  ::setenv("TOY_GAIN", "0.25", 1);  // of which the bytes of program and plugin know nothing
  EXPECT_EQ(small.check().exit_code, 0);
  small.rebuild("0.25");
  EXPECT_EQ(small.check().exit_code, 1);
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
  ASSERT_EQ(small.check("--update --seeds 4").exit_code, 0);
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

  // An experiment that lists seeds has its spread already.
  small.rebuild("1");
  small.experiment["solvers"][0].erase("seed");
  small.experiment["solvers"][0]["seeds"] = {1, 2, 3, 4, 5};
  fs::remove_all(small.folder() / "results");
  ASSERT_EQ(small.check("--update").exit_code, 0);
  EXPECT_EQ(row_of(small.baseline(), "net").at("seeds"), json({1, 2, 3, 4, 5}));
  EXPECT_FALSE(fs::exists(small.folder() / "results/small/check/seeds"));
}

TEST(CheckProgram, AFailedTrialIsWorseAndNoBaseline) {
  CheckedExperiment small("failed");
  small.experiment["solvers"] = {
      {{"type", "tsvd"}, {"rank", 30}},
      {{"type", "toy-learned"}, {"seeds", {1, 2, 3}}, {"label", "net"}, {"how", "crash"}}};
  ASSERT_EQ(small.check("--update --seeds 3").exit_code, 0);
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

TEST(CheckProgram, StoredSolversMustMakeTheImagesThatTheyOnceMade) {
  CheckedExperiment small("stored");
  const fs::path networks = small.folder() / "networks";
  fs::create_directories(networks);
  write_text(networks / "small tsvd.json", R"({"type": "tsvd", "rank": 20})");
  write_text(networks / "other.json", R"({"type": "pdipm"})");  // not in the experiment
  EXPECT_EQ(small.check("--update").exit_code, 1);              // no frames yet
  ASSERT_EQ(run_program(small.folder().path(),
                        "generate small.json --dataset test --out networks/frames.h5")
                .exit_code,
            0);
  const std::string images = "'networks/small tsvd.images.h5'";
  ASSERT_EQ(run_program(small.folder().path(),
                        "reconstruct --solver 'networks/small tsvd.json' --input "
                        "networks/frames.h5 --output " +
                            images)
                .exit_code,
            0);
  ASSERT_EQ(small.check("--update").exit_code, 0);
  Outcome outcome = small.check("--all");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "stored small tsvd")) << outcome.output;
  EXPECT_FALSE(contains(outcome, "stored other")) << outcome.output;
  {
    Hdf5File file = Hdf5File::open_writable(networks / "small tsvd.images.h5");
    RowMajorMatrix changed = file.read_rows("/conductivity_change", 5, 1);
    changed *= 1.0002;
    file.write_rows("/conductivity_change", 5, changed);
  }
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok, 1 worse")) << outcome.output;
  write_text(networks / "small tsvd.json", R"({"type": "tsvd", "checkpoint": "absent.fitted"})");
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "failed; see results/small/check/networks/small tsvd.log"))
      << outcome.output;
}

}  // namespace
}  // namespace ertbench
