#include "bench/publish/publish.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "bench/features/features.h"
#include "bench/publish/latency_pairs.h"
#include "bench/publish/origins.h"
#include "bench/speed/load_run.h"
#include "core/errors.h"
#include "core/files.h"
#include "solvers/registry/registry.h"
#include "tests/bench/figure_testing.h"
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

TEST_F(PublishTest, NamesAChangedFileWithABlankAsItIs) {
  testing::write_text(project() / "new file.txt", "");
  EXPECT_NE(refusal().find(": new file.txt differ"), std::string::npos) << refusal();
}

TEST_F(PublishTest, RefusesABuildOfOtherSources) {
  EXPECT_NE(refusal().find("this program was built of commit"), std::string::npos) << refusal();
  // What publishing itself writes is no change.
  testing::write_text(project() / "results/published/e/table.md", "");
  testing::write_text(project() / "results/published/e/README.md", "");
  testing::write_text(project() / "results/published/e/training/eit-nn mse.csv", "");
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
  // What a publishing that was cut off has left is no page.
  testing::write_text(project() / "results/published/e.before/README.md.in", "{{nothing}}\n");
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

TEST_F(PublishTest, PutsAComparisonOfTheSheetsModelsIntoItsPlace) {
  nlohmann::json small = testing::small_experiment();
  small["datasets"]["test"]["count"] = 5;
  small["datasets"]["validation"]["count"] = 2;
  testing::write_text(project() / "e.json", small.dump());
  SolverRegistry registry;
  const Experiment experiment = read_experiment(project() / "e.json", registry, chart_types());
  const auto run = testing::run_program(project(), "fidelity e.json --out results/e");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(
      publish_experiment(experiment, project(), Cache(project() / "cache"), 1, Publishing::models),
      0);
  const auto published = project() / "results/published/e";
  EXPECT_EQ(testing::read_text(published / "fidelity.csv"),
            testing::read_text(project() / "results/e/fidelity.csv"));
  EXPECT_TRUE(std::filesystem::exists(published / "provenance.json"));
  EXPECT_FALSE(std::filesystem::exists(published / "summary.json"));
  // Without its figure it is not published, and what was published stays.
  const std::string drawn = testing::read_text(published / "fidelity.svg");
  const testing::Environment no_gnuplot("PATH", (project() / "core").string());
  try {
    publish_experiment(experiment, project(), Cache(project() / "cache"), 1, Publishing::models);
    FAIL() << "published without its figure";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("fidelity.svg could not be drawn"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(testing::read_text(published / "fidelity.svg"), drawn);
  EXPECT_TRUE(std::filesystem::exists(published / "fidelity.png"));
  EXPECT_TRUE(std::filesystem::exists(published / "README.md.in"));
}

TEST_F(PublishTest, PutsRatesOfFramesIntoTheirPlaceWithWhatFailed) {
  nlohmann::json small = testing::small_experiment();
  small["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  small["solvers"] = {{{"type", "misbehaving"}, {"label", "lost"}, {"how", "crash"}}};
  testing::write_text(project() / "e.json", small.dump());
  SolverRegistry registry;
  const Experiment experiment =
      read_experiment(project() / "e.json", registry, {}, SolverCheck::none);
  EXPECT_EQ(publish_load(experiment, registry, project(), Cache(project() / "cache")), 1);
  const auto published = project() / "results/published/e";
  const nlohmann::json load = nlohmann::json::parse(testing::read_text(published / "load.json"));
  ASSERT_EQ(load.at("rows").size(), 1u);
  const auto failure = load.at("rows").at(0).at("failure").get<std::string>();
  EXPECT_NE(failure.find("Aborted"), std::string::npos) << failure;
  EXPECT_TRUE(std::filesystem::exists(published / "load.svg"));
  EXPECT_TRUE(std::filesystem::exists(published / "README.md.in"));
}

TEST(PublishLoad, RefusesRatesThatWereTakenOnABusyMachine) {
  LoadResults results;
  results.solvers.resize(2);
  results.solvers[0].label = "calm";
  results.solvers[0].lost_share = 0.01;
  results.solvers[1].label = "disturbed";
  EXPECT_NO_THROW(require_undisturbed(results, "published/load"));
  results.solvers[1].lost_share = 0.07;
  try {
    require_undisturbed(results, "published/load");
    FAIL() << "accepted";
  } catch (const InputError& e) {
    EXPECT_EQ(std::string(e.what()).find("published/load: \"disturbed\" lost 7 % of its time"), 0U)
        << e.what();
  }
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
  const auto timed = [](const std::string& result, const nlohmann::json& parameters,
                        const std::vector<std::vector<double>>& rounds, double calibration,
                        const std::string& commit = "1", const std::string& system = "Linux 1") {
    std::vector<ResultRow> rows;
    for (const auto& of_row : rounds) {
      rows.push_back(timed_row("net", parameters, of_row, calibration));
      rows.back().build.timed.front().commit = commit;
    }
    const std::vector<TimedSolver> solvers =
        timed_solvers(result, {{"cpu", "cpu"}, {"commit", commit}, {"system", system}}, rows);
    EXPECT_EQ(solvers.size(), 1U);
    return solvers.front();
  };
  const std::vector<TimedSolver> rows = {
      timed("a", {{"width", 24}, {"epochs", 5}}, {{100, 110}}, 10),
      // Of two test sets, the second timed on a busier machine.
      timed("b", {{"width", 24}, {"epochs", 9}}, {{120, 130}, {108, 140}}, 10),
      timed("c", {{"width", 24}}, {{200, 220}}, 20),
      timed("d", {{"width", 24}}, {{300, 310}}, 10, "2"),
      timed("e", {{"width", 24}}, {{400, 410}}, 10, "2"),
      timed("f", {{"width", 12}}, {{50, 51}}, 10),
      timed("g", {{"width", 24}}, {{500, 510}}, 10, "2", "Linux 2")};
  EXPECT_EQ(latency_interval(rows[1]).high, 140);
  const std::vector<LatencyPair> pairs = latency_pairs(rows);
  const auto pair = [&](const std::string& a, const std::string& b) {
    return *std::find_if(pairs.begin(), pairs.end(), [&](const LatencyPair& one) {
      return one.first.result == a && one.second.result == b;
    });
  };
  EXPECT_EQ(pairs.size(), 15U);  // of a to e and g; f is of another width
  EXPECT_TRUE(pair("a", "b").agree);
  EXPECT_TRUE(pair("a", "c").agree);  // in units of the calibration loop
  EXPECT_FALSE(pair("a", "d").agree);
  EXPECT_EQ(pair("a", "d").reason,
            "other builds: commit 1, program program; commit 2, program program");
  EXPECT_FALSE(pair("d", "e").agree);
  EXPECT_EQ(pair("d", "e").reason, "");
  EXPECT_EQ(pair("e", "g").reason, "other machines of one name, cpu: Linux 1; Linux 2");
  EXPECT_NE(rows[0].settings, rows[5].settings);
  const std::vector<TimedSolver> near = {rows[3], timed("h", {{"width", 24}}, {{312}}, 10, "2"),
                                         timed("i", {{"width", 24}}, {{315}}, 10, "2")};
  EXPECT_TRUE(latency_pairs(near)[0].agree) << "by less than a hundredth of 310";
  EXPECT_FALSE(latency_pairs(near)[1].agree);
}

TEST(LatencyPairs, SolversWhoseWorkFollowsTheFrameAreHeldAgainstTheSameFrames) {
  const auto of = [](const std::string& result, const nlohmann::json& parameters,
                     double radius) -> TimedSolver {
    const nlohmann::json test_set = {{"scenes", {{"radius", {radius, radius}}}}};
    return timed_solvers(result, {{"datasets", {{"test", test_set}}}},
                         {timed_row("any", parameters, {100, 110}, 10)})
        .front();
  };
  for (const nlohmann::json& follows :
       {nlohmann::json{{"tolerance", 1e-4}}, nlohmann::json{{"most_contacts", 4}},
        nlohmann::json{{"components", 64}}}) {
    EXPECT_TRUE(latency_pairs({of("a", follows, 0.4), of("b", follows, 0.2)}).empty()) << follows;
    EXPECT_EQ(latency_pairs({of("a", follows, 0.4), of("b", follows, 0.4)}).size(), 1U) << follows;
  }
  const nlohmann::json product = {{"components", 1}};
  EXPECT_EQ(latency_pairs({of("a", product, 0.4), of("b", product, 0.2)}).size(), 1U);
}

TEST(LatencyPairs, AFrameOfMoreElectrodesIsAnotherFrame) {
  const auto of = [](int electrodes) {
    const nlohmann::json test_set = {
        {"sensor", {{"electrode_count", electrodes}, {"background", 0.01 * electrodes}}}};
    return timed_solvers("any", {{"datasets", {{"test", test_set}}}},
                         {timed_row("net", {{"width", 24}}, {100, 110}, 10)})
        .front()
        .settings;
  };
  EXPECT_EQ(of(16), of(16));
  EXPECT_NE(of(16), of(32));
}

TEST(LatencyPairs, EachRoundHasTheUnitThatRanBesideIt) {
  // The machine ran at half its speed for a round of the second; only the round's unit tells.
  const auto of = [](const std::string& result, std::vector<double> rounds,
                     std::vector<double> units) {
    ResultRow row = timed_row("net", {{"width", 24}}, std::move(rounds), 10);
    row.latency_us->relative_of_rounds = std::move(units);
    return timed_solvers(result, nlohmann::json::object(), {row}).front();
  };
  EXPECT_TRUE(latency_pairs({of("a", {100, 110}, {10, 11}), of("b", {190, 200}, {10.5, 12})})
                  .front()
                  .agree);
  EXPECT_FALSE(
      latency_pairs({of("a", {100, 110}, {10, 11}), of("b", {190, 200}, {19, 20})}).front().agree);
}

/// A folder that is being made, or was left when a call was cut off, is no result.
TEST(LatencyPairs, AreOfFinishedResults) {
  namespace fs = std::filesystem;
  const fs::path made = fs::path(ERTBENCH_SOURCE_DIR) / "results/published/quick/summary.json";
  const TemporaryFolder folder("published");
  std::vector<std::size_t> solvers;
  for (const char* name : {"quick", "quick.part", "quick.before"}) {
    fs::create_directory(folder / name);
    fs::copy_file(made, folder / name / "summary.json");
    solvers.push_back(timed_solvers(folder.path()).size());
  }
  EXPECT_GT(solvers[0], 0U);
  EXPECT_EQ(solvers, std::vector<std::size_t>(3, solvers[0]));
}

TEST(LatencyPairs, TheSystemIsThatOfTheClocks) {
  const TemporaryFolder folder("published");
  std::filesystem::create_directory(folder / "a");
  const auto systems = [&](const nlohmann::json& clocks) {
    const std::filesystem::path made = ERTBENCH_SOURCE_DIR "/results/published/quick/summary.json";
    nlohmann::json summary = nlohmann::json::parse(testing::read_text(made));
    summary["provenance"]["cpu"] = "cpu";
    summary["provenance"]["system"] = "Linux 1";
    for (nlohmann::json& row : summary.at("rows")) {
      if (row.contains("timed_on")) row["timed_on"]["cpu"] = "cpu";
    }
    summary.erase("clocks");
    if (!clocks.is_null()) summary["clocks"] = clocks;
    testing::write_text(folder / "a/summary.json", summary.dump());
    std::set<std::string> out;
    for (const TimedSolver& timed : timed_solvers(folder.path())) out.insert(timed.system);
    return out;
  };
  EXPECT_EQ(systems({}), std::set<std::string>{"Linux 1"});
  EXPECT_EQ(systems({{"system", "Linux 2"}}), std::set<std::string>{"Linux 2"});
  EXPECT_EQ(systems({{"date", "of clocks that did not say"}}), std::set<std::string>{""});
}

/// Two published tables that time the same solver with the same settings agree, or say why not.
TEST(LatencyPairs, AllOfThePublishedOnesAgreeOrHaveAReason) {
  const std::filesystem::path published =
      std::filesystem::path(ERTBENCH_SOURCE_DIR) / "results/published";
  const std::vector<LatencyPair> pairs = latency_pairs(timed_solvers(published));
  for (const LatencyPair& pair : pairs) {
    EXPECT_TRUE(pair.agree || !pair.reason.empty())
        << pair.first.label << " in " << pair.first.result << " and " << pair.second.result;
  }
}

TEST(Origins, NameEachResultsCodeAndClocks) {
  const TemporaryFolder folder("origins");
  const nlohmann::json build = {{"commit", "0123456789ab"}, {"code", "models abcdefghij"}};
  nlohmann::json summary = {
      {"provenance", {{"commit", "1"}, {"cpu", "first"}, {"date", "2026-01-02T03:04:05Z"}}},
      {"builds",
       {{"fits", {build}},
        {"accuracy", {{{"commit", "222222222222"}, {"code", "klmnopqrst"}}}},
        {"timing", {{{"commit", "333333333333"}, {"code", "klmnopqrst"}}}}}},
      {"rows", {{{"latency_us", {{"p50", 1}}}, {"timed_on", {{"cpu", "second"}}}}}},
      {"clocks", {{"date", "2026-05-06T07:08:09Z"}}}};
  for (const char* name : {"a", "b", "c", "c.part", "d", "e"}) {
    std::filesystem::create_directories(folder / name);
  }
  testing::write_text(folder / "a/summary.json", summary.dump());
  testing::write_text(folder / "c.part/summary.json", summary.dump());
  testing::write_text(folder / "c/provenance.json", summary.at("provenance").dump());
  nlohmann::json of_models = summary.at("provenance");
  of_models["builds"] = {{"fidelity", summary.at("builds").at("accuracy")}};
  testing::write_text(folder / "e/provenance.json", of_models.dump());
  const nlohmann::json load = {{"provenance", summary.at("provenance")},
                               {"rows", {{{"service_us", {{"p50", 1}}}}}}};
  testing::write_text(folder / "d/load.json", load.dump());
  std::vector<std::vector<std::string>> rows;
  const Table table = origins_table(folder.path());
  for (const auto& cells : table.sections.at(0).rows) {
    std::vector<std::string>& row = rows.emplace_back();
    for (const Cell& cell : cells) row.push_back(cell.text);
  }
  const std::vector<std::vector<std::string>> expected = {
      {"a", "0123456789ab, 222222222222", "klmnopqr", "abcdefgh", "2026-01-02", "first",
       "2026-05-06", "second"},
      {"c", "1", "—", "—", "2026-01-02", "first", "—", "—"},
      {"d", "1", "—", "—", "2026-01-02", "first", "2026-01-02", "first"},
      {"e", "222222222222", "klmnopqr", "—", "2026-01-02", "first", "—", "—"}};
  EXPECT_EQ(rows, expected);
  const std::string one = "Scores: all that say it are of one code, klmnopqr. Networks: all";
  EXPECT_NE(table.text.find(one), std::string::npos) << table.text;

  summary["builds"]["accuracy"][0]["code"] = "uvwxyzabcd";
  testing::write_text(folder / "d/summary.json", summary.dump());
  const std::string two = "Scores: they are of different codes, klmnopqr, uvwxyzab.";
  const std::string text = origins_table(folder.path()).text;
  EXPECT_NE(text.find(two), std::string::npos) << text;
}

TEST(ProjectPages, LatenciesAndBuildsStandAsTheResultsHaveThem) {
  const std::filesystem::path project = ERTBENCH_SOURCE_DIR;
  int found = 0;
  for (const auto& [page, text] : rendered_pages(project)) {
    if (page.filename() == "latencies.md" || page.filename() == "builds.md") {
      EXPECT_EQ(testing::read_text(page), text);
      ++found;
    }
  }
  EXPECT_EQ(found, 2);
}

}  // namespace
}  // namespace ertbench
