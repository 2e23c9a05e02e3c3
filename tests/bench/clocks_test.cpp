#include "bench/publish/clocks.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "bench/experiment/solver_entry.h"
#include "bench/features/features.h"
#include "bench/publish/publish.h"
#include "bench/publish/published_result.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// A project with a result that was published on another machine, long ago.
class ClocksTest : public ::testing::Test {
 protected:
  ClocksTest() {
    // That of the learned solvers stands beside the program, which this test is not.
    ::setenv("ERTBENCH_PLUGINS", fs::path(ERTBENCH_PROGRAM).parent_path().c_str(), 1);
    json experiment = small_experiment();
    experiment["datasets"]["train"] = {{"count", 600},
                                       {"seed", 1},
                                       {"snr_db", 50},
                                       {"snr_basis", "absolute"},
                                       {"scenes", json::object()}};
    experiment["solvers"] = {
        {{"type", "tsvd"}, {"rank", 30}},
        {{"type", "fcnn"}, {"widths", {16, 8, 8}}, {"epochs", 2}, {"seeds", {1, 2}}}};
    experiment["timing"] = {{"frames", 662}, {"rounds", 2}};
    write_text(project() / "e.json", experiment.dump());
    fs::create_directories(published());
    write_text(published() / "README.md.in", "{{.3f e tsvd RIE}}\n");
    write_text(published() / "README.md", "a page\n");
    const Outcome run = run_program(project(), "run e.json --out results/e");
    EXPECT_EQ(run.exit_code, 0) << run.output;
    SolverRegistry registry;
    publish_experiment(read_experiment(project() / "e.json", registry, chart_types()), project(),
                       cache(), 1);
    json summary = summary_of(published());
    for (json& row : summary.at("rows")) {
      if (row.at("latency_us").is_null()) continue;
      row["latency_us"]["p50"] = 77777;
      row["timed_on"]["cpu"] = "another";
      row["peak_rss_mb"] = 5;
    }
    write_text(published() / "summary.json", summary.dump());
  }

  ~ClocksTest() override { ::unsetenv("ERTBENCH_PLUGINS"); }

  /// What take() does, which has to be the program for that.
  void measure() const {
    const Outcome full = run_program(project(), "run e.json --out results/clocks/e");
    ASSERT_EQ(full.exit_code, 0) << full.output;
    const Outcome brief =
        run_program(project(),
                    "run e.json --set datasets.train.count=512 --set /solvers/1/epochs=1 "
                    "--out results/clocks/e-trained");
    ASSERT_EQ(brief.exit_code, 0) << brief.output;
  }

  std::string refusal(const std::string& file = "e.json") const {
    try {
      Clocks({project() / file}, project(), cache()).write();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path project() const { return folder_.path(); }
  fs::path published() const { return project() / "results/published/e"; }
  Cache cache() const { return Cache(project() / "cache"); }

  TemporaryFolder folder_{"clocks"};
};

TEST_F(ClocksTest, AreTakenAgainAndAllElseStays) {
  const json before = summary_of(published());
  measure();
  Clocks({project() / "e.json"}, project(), cache()).write();
  const json after = summary_of(published());
  for (const char* label : {"tsvd", "fcnn"}) {
    json old_row = row_of(before, label);
    json new_row = row_of(after, label);
    EXPECT_LT(new_row.at("latency_us").at("p50"), 10000) << label;
    EXPECT_NE(new_row.at("timed_on").at("cpu"), "another") << label;
    EXPECT_EQ(new_row.at("latency_us").at("p50_of_rounds").size(), 2U) << label;
    EXPECT_EQ(new_row.at("build").at("timed").size(), 1U) << label;
    for (json* row : {&old_row, &new_row}) {
      for (const char* time : {"latency_us", "timed_on", "calibration_us", "frames_per_s"}) {
        row->erase(time);
      }
      row->at("build").erase("timed");
    }
    EXPECT_EQ(old_row, new_row) << label;  // metrics, seeds, fit, memory
  }
  EXPECT_EQ(after.at("clocks").at("briefly_trained"), json({"fcnn"}));
  EXPECT_EQ(after.at("clocks").at("system"), after.at("provenance").at("system"));
  EXPECT_EQ(after.at("provenance"), before.at("provenance"));
  const std::string table = read_text(published() / "table.md");
  EXPECT_NE(table.find("Times: taken apart from all other numbers, at"), std::string::npos)
      << table;
  EXPECT_EQ(table.find("77777"), std::string::npos);
  EXPECT_EQ(read_text(published() / "README.md"), "a page\n");
  const std::string page = read_text(published() / "report.html");
  EXPECT_NE(page.find("Times: taken apart from all other numbers, at"), std::string::npos);
  EXPECT_NE(page.find("Reconstructions"), std::string::npos);
  EXPECT_NE(page.find("Training curves"), std::string::npos);
}

// What another machine scored is here as records and logs; neither its fits nor its clock are.
TEST_F(ClocksTest, StayWhereAllElseIsMadeAgain) {
  const json right = summary_of(published());
  json wrong = right;
  for (json& row : wrong.at("rows")) row["metrics"]["RIE"]["mean"] = 5;
  write_text(published() / "summary.json", wrong.dump());
  fs::remove_all(published() / "training");
  const fs::path results = project() / "results/e";
  ASSERT_TRUE(fs::exists(results / "training/fcnn.seed2.csv"));
  for (const auto& entry : fs::directory_iterator(results / "records")) {
    if (entry.path().string().find(".timing.") != std::string::npos) fs::remove(entry.path());
  }
  SolverRegistry registry;
  const Experiment experiment = read_experiment(project() / "e.json", registry, chart_types());
  for (const SolverEntry& entry : experiment.solvers) {
    const FitRecipe recipe = fit_recipe(experiment, entry);
    fs::remove(cache().fitted_solver(recipe));
    fs::remove_all(cache().work_folder(recipe));
  }
  EXPECT_EQ(publish_experiment(experiment, project(), cache(), 1, Publishing::scores), 0);
  const json after = summary_of(published());
  EXPECT_EQ(after.at("rows"), right.at("rows"));  // their times are those of the fixture
  EXPECT_EQ(row_of(after, "fcnn").at("latency_us").at("p50"), 77777);
  EXPECT_EQ(after.at("builds"), right.at("builds"));
  EXPECT_EQ(after.at("clocks").at("date"), right.at("provenance").at("date"));
  EXPECT_NE(read_text(published() / "table.md").find("Times: taken apart from all other numbers"),
            std::string::npos);
  EXPECT_TRUE(fs::exists(published() / "training/fcnn.seed2.csv"));
  EXPECT_NE(read_text(published() / "report.html").find("Training curves"), std::string::npos);
  EXPECT_EQ(read_text(published() / "README.md"), "a page\n");
}

/// Tables, charts and page follow from summary.json, which stays.
TEST_F(ClocksTest, StayWhereAResultIsDrawnAgain) {
  const Experiment experiment = [&] {
    SolverRegistry registry;
    return read_experiment(project() / "e.json", registry, chart_types());
  }();
  redraw_published(experiment, published());
  const std::string table = read_text(published() / "table.md");
  EXPECT_NE(table.find("77777 |"), std::string::npos) << table;  // that of the machine of long ago
  const std::string summary = read_text(published() / "summary.json");
  for (const char* name : {"table.md", "table.csv", "report.html"}) {
    write_text(published() / name, "of an older program");
  }
  redraw_published(experiment, published());
  EXPECT_EQ(read_text(published() / "table.md"), table);
  EXPECT_NE(read_text(published() / "report.html").find("</html>"), std::string::npos);
  EXPECT_EQ(read_text(published() / "summary.json"), summary);
  EXPECT_EQ(read_text(published() / "README.md"), "a page\n");
}

TEST_F(ClocksTest, OfANewSolverHaveToBeTaken) {
  json summary = summary_of(published());
  for (json& row : summary.at("rows")) {
    if (row.at("label") == "fcnn") row["latency_us"] = nullptr;
  }
  const std::string before = summary.dump();
  write_text(published() / "summary.json", before);
  SolverRegistry registry;
  const Experiment experiment = read_experiment(project() / "e.json", registry, chart_types());
  try {
    publish_experiment(experiment, project(), cache(), 1, Publishing::scores);
    FAIL() << "published without a time";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("\"fcnn\" has no time in it; publish e as a whole"),
              std::string::npos)
        << error.what();
  }
  EXPECT_EQ(read_text(published() / "summary.json"), before);
}

TEST_F(ClocksTest, StayAsTheyWereWhereSomethingIsMissing) {
  const std::string before = read_text(published() / "summary.json");
  EXPECT_NE(refusal().find("there is no record of this round"), std::string::npos) << refusal();
  json experiment = json::parse(read_text(project() / "e.json"));
  write_text(project() / "f.json", experiment.dump());
  EXPECT_NE(refusal("f.json").find("there is no such result"), std::string::npos);
  const fs::path rates = project() / "results/published/f/load.json";
  fs::create_directories(rates.parent_path());
  write_text(rates, "{}");
  EXPECT_NE(refusal("f.json").find("publish --load"), std::string::npos) << refusal("f.json");
  experiment["solvers"][0]["label"] = "other";
  write_text(project() / "e.json", experiment.dump());
  EXPECT_NE(refusal().find("has no solver \"tsvd\" any more"), std::string::npos) << refusal();
  experiment["datasets"]["test"]["seed"] = 4;
  write_text(project() / "e.json", experiment.dump());
  EXPECT_NE(refusal().find("the dataset \"test\""), std::string::npos) << refusal();
  EXPECT_EQ(read_text(published() / "summary.json"), before);
}

}  // namespace
}  // namespace ertbench
