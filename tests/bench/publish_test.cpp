#include "bench/publish/publish.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "bench/charts/chart_types.h"
#include "bench/publish/latency_pairs.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using testing::TemporaryFolder;

/// A project of its own, in git.
class PublishTest : public ::testing::Test {
 protected:
  PublishTest() {
    std::filesystem::create_directories(project() / "docs");
    std::filesystem::create_directories(project() / "core");
    std::filesystem::create_directories(project() / "results/published/e");
    testing::write_text(project() / "core/a.cpp", "int a;\n");
    testing::write_text(project() / "e.json", testing::small_experiment().dump());
    testing::write_text(project() / "results/published/e/README.md.in", "{{.3f e tsvd RIE}}\n");
    testing::write_text(project() / ".gitignore", "results/e\ncache\n");
    git("init -q");
    git("add -A");
    git("-c user.name=a -c user.email=b commit -qm first");
  }

  std::filesystem::path project() const { return folder_.path(); }

  void git(const std::string& arguments) const {
    const std::string command = "git -C '" + project().string() + "' " + arguments;
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
  }

  std::string refusal() const {
    try {
      require_committed(project());
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_{"publish"};
};

TEST_F(PublishTest, RefusesATreeWithChanges) {
  testing::write_text(project() / "core/a.cpp", "int b;\n");
  EXPECT_NE(refusal().find("core/a.cpp differ from the last commit"), std::string::npos)
      << refusal();
  git("checkout -q core/a.cpp");
  testing::write_text(project() / "new.txt", "");
  EXPECT_NE(refusal().find("new.txt"), std::string::npos) << refusal();
}

TEST_F(PublishTest, RefusesABuildOfOtherSources) {
  EXPECT_NE(refusal().find("this program was built of commit"), std::string::npos) << refusal();
  // What publishing itself writes is no change.
  testing::write_text(project() / "results/published/e/table.md", "");
  testing::write_text(project() / "results/published/e/README.md", "");
  EXPECT_NE(refusal().find("this program was built of commit"), std::string::npos) << refusal();
}

TEST_F(PublishTest, PutsResultsAndPagesIntoTheirPlace) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(project() / "e.json", registry, chart_types());
  // The trials are processes of the program, which this test is not: their records are made first.
  const auto run = testing::run_program(project(), "run e.json --out results/e");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  testing::write_text(project() / "results/published/e/old.svg", "from before");
  EXPECT_EQ(publish_experiment(experiment, project(), Cache(project() / "cache"), 1), 0);
  publish_pages(project());
  const auto published = project() / "results/published/e";
  EXPECT_FALSE(std::filesystem::exists(published / "old.svg"));
  EXPECT_TRUE(std::filesystem::exists(published / "summary.json"));
  EXPECT_TRUE(std::filesystem::exists(published / "README.md.in"));
  const double rie =
      testing::row_of(testing::summary_of(published), "tsvd").at("metrics").at("RIE").at("mean");
  char text[32];
  std::snprintf(text, sizeof text, "%.3f\n", rie);
  EXPECT_EQ(testing::read_text(published / "README.md"), text);
}

ResultRow timed_row(const std::string& type, nlohmann::json parameters, std::vector<double> rounds,
                    double calibration) {
  ResultRow row;
  row.label = row.type = type;
  row.dataset = "test";
  row.parameters = std::move(parameters);
  row.latency_us = LatencySummary{rounds.front(), 2 * rounds.front(), 3 * rounds.front(), rounds};
  row.calibration_us = calibration;
  row.build.timed = {{"0123456789ab", false, "program", "code", {}}};
  return row;
}

TEST(LatencyPairs, AgreeWhereTheirIntervalsMeetOrHaveAReason) {
  const std::vector<TimedRow> rows = {
      {"a", timed_row("net", {{"width", 24}, {"epochs", 5}}, {100, 110}, 10), "cpu", "build 1"},
      {"b", timed_row("net", {{"width", 24}, {"epochs", 9}}, {108, 120}, 10), "cpu", "build 1"},
      {"c", timed_row("net", {{"width", 24}}, {200, 220}, 20), "cpu", "build 1"},
      {"d", timed_row("net", {{"width", 24}}, {300, 310}, 10), "cpu", "build 2"},
      {"e", timed_row("net", {{"width", 24}}, {400, 410}, 10), "cpu", "build 2"},
      {"f", timed_row("net", {{"width", 12}}, {50, 51}, 10), "cpu", "build 1"}};
  const std::vector<LatencyPair> pairs = latency_pairs(rows);
  const auto pair = [&](const std::string& a, const std::string& b) {
    return *std::find_if(pairs.begin(), pairs.end(), [&](const LatencyPair& one) {
      return one.first.result == a && one.second.result == b;
    });
  };
  EXPECT_EQ(pairs.size(), 10U);  // of a to e; f is of another width
  EXPECT_TRUE(pair("a", "b").agree);
  EXPECT_TRUE(pair("a", "c").agree);  // in units of the calibration loop
  EXPECT_FALSE(pair("a", "d").agree);
  EXPECT_EQ(pair("a", "d").reason, "other builds: build 1; build 2");
  EXPECT_FALSE(pair("d", "e").agree);
  EXPECT_EQ(pair("d", "e").reason, "");
  EXPECT_NE(timed_settings(rows[0].row), timed_settings(rows[5].row));
}

/// Two published tables that time the same solver with the same settings agree, or say why not.
TEST(LatencyPairs, AllOfThePublishedOnesAgreeOrHaveAReason) {
  const std::filesystem::path published =
      std::filesystem::path(ERTBENCH_SOURCE_DIR) / "results/published";
  const std::vector<LatencyPair> pairs = latency_pairs(timed_rows(published));
  for (const LatencyPair& pair : pairs) {
    EXPECT_TRUE(pair.agree || !pair.reason.empty())
        << pair.first.row.label << " in " << pair.first.result << " and " << pair.second.result;
  }
}

TEST(ProjectPages, TheLatenciesStandAsTheResultsHaveThem) {
  const std::filesystem::path project = ERTBENCH_SOURCE_DIR;
  for (const auto& [page, text] : rendered_pages(project)) {
    if (page.filename() == "latencies.md") {
      EXPECT_EQ(testing::read_text(page), text);
    }
  }
}

}  // namespace
}  // namespace ertbench
