#include "bench/publish/publish.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "bench/features/features.h"
#include "bench/record/limit_file.h"
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
    testing::write_text(project() / "results/published/e/README.md.in",
                        "[{{.3f e tsvd RIE}}](table.md), table.csv\n");
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
  // What an interrupted call has left is no page.
  testing::write_text(project() / "results/published/e.part/README.md.in", "{{nothing}}\n");
  publish_pages(project());
  const auto published = project() / "results/published/e";
  EXPECT_FALSE(std::filesystem::exists(published / "old.svg"));
  EXPECT_TRUE(std::filesystem::exists(published / "summary.json"));
  EXPECT_TRUE(std::filesystem::exists(published / "table.md"));
  EXPECT_TRUE(std::filesystem::exists(published / "README.md.in"));
  EXPECT_FALSE(std::filesystem::exists(published / "report.html"));  // no page names it
  // Shorter, with the same numbers to seven digits.
  const auto whole = project() / "results/e";
  EXPECT_LT(std::filesystem::file_size(published / "summary.json"),
            std::filesystem::file_size(whole / "summary.json") / 2);
  const auto metrics_in = [](const std::filesystem::path& folder) {
    return testing::row_of(testing::summary_of(folder), "tsvd").at("metrics").flatten();
  };
  const auto shown = metrics_in(published);
  for (const auto& [place, exact] : metrics_in(whole).items()) {
    if (!exact.is_number()) continue;
    const double value = exact;
    EXPECT_NEAR(shown.at(place).get<double>(), value, 6e-7 * std::abs(value)) << place;
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.7g", value);
    EXPECT_EQ(shown.at(place).get<double>(), std::strtod(digits, nullptr)) << place;
  }
  const double rie =
      testing::row_of(testing::summary_of(published), "tsvd").at("metrics").at("RIE").at("mean");
  char text[32];
  std::snprintf(text, sizeof text, "[%.3f](table.md), table.csv\n", rie);
  EXPECT_EQ(testing::read_text(published / "README.md"), text);

  // Drawn again of its summary it is what it was, and what no summary holds stays.
  const std::string table = testing::read_text(published / "table.md");
  const std::string exact = testing::read_text(published / "table.csv");
  testing::write_text(published / "table.md", "from another version\n");
  testing::write_text(published / "levels.csv", "of a ladder\n");
  redraw_published("e", project());
  EXPECT_EQ(testing::read_text(published / "table.md"), table);
  EXPECT_EQ(testing::read_text(published / "table.csv"), exact);
  EXPECT_EQ(testing::read_text(published / "levels.csv"), "of a ladder\n");
  EXPECT_EQ(testing::read_text(published / "README.md"), text);
  EXPECT_THROW(redraw_published("another", project()), InputError);
  EXPECT_FALSE(std::filesystem::exists(project() / "results/published/another"));
}

TEST_F(PublishTest, KeepsLimitsOfTheSameScenesAndRefusesToLoseOthers) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(project() / "e.json", registry, chart_types());
  const auto run = testing::run_program(project(), "run e.json --out results/e");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const auto published = project() / "results/published/e";
  const auto publish = [&] {
    return publish_experiment(experiment, project(), Cache(project() / "cache"), 1);
  };
  ASSERT_EQ(publish(), 0);
  const DatasetSpec& set = experiment.tests.front();
  nlohmann::json summary = testing::summary_of(published);
  nlohmann::json limit = testing::row_of(summary, "tsvd");
  limit["type"] = limit["family"] = limit["label"] = limit_oracle;
  limit["frames"] = 7;
  limit["parameters"] = {{"set", limit_key(set, set)}};
  limit["build"]["scored"] = {{{"commit", "abc"}, {"dirty", false}, {"program", "1"}}};
  summary["rows"].push_back(limit);
  testing::write_text(published / "summary.json", summary.dump());
  ASSERT_EQ(publish(), 0);
  summary = testing::summary_of(published);
  EXPECT_EQ(testing::row_of(summary, limit_oracle).at("frames"), 7);
  // One that was computed since replaces it.
  nlohmann::json computed =
      nlohmann::json::parse(testing::read_text(project() / "results/e/limit.json"));
  computed["rows"][0]["frames"] = 8;
  testing::write_text(project() / "results/e/limit.json", computed.dump());
  ASSERT_EQ(publish(), 0);
  summary = testing::summary_of(published);
  EXPECT_EQ(testing::row_of(summary, limit_oracle).at("frames"), 8);

  std::filesystem::remove(project() / "results/e/limit.json");
  for (nlohmann::json& row : summary["rows"]) {
    if (row.at("type") == limit_oracle) row["parameters"]["set"] = "of other scenes";
  }
  testing::write_text(published / "summary.json", summary.dump());
  EXPECT_THROW(publish(), InputError);
  EXPECT_EQ(testing::summary_of(published), summary);
}

TEST_F(PublishTest, KeepsTheNestedFilesThatPagesName) {
  testing::write_text(project() / "docs/a.md", "[log](../results/published/e/training/my net.csv)");
  const auto made = project() / "made";
  std::filesystem::create_directories(made / "maps");
  std::filesystem::create_directories(made / "training");
  testing::write_text(project() / "results/published/e/README.md.in", "![](skin_curve.png)");
  for (const char* name : {"summary.json", "training/my net.csv", "training/net.csv", "maps/a.csv",
                           "skin_curve.png", "curve.png"})
    testing::write_text(made / name, "text");
  prune(made, project(), project() / "results/published/e");
  EXPECT_TRUE(std::filesystem::exists(made / "summary.json"));
  EXPECT_TRUE(std::filesystem::exists(made / "training/my net.csv"));
  EXPECT_FALSE(std::filesystem::exists(made / "training/net.csv"));
  EXPECT_FALSE(std::filesystem::exists(made / "maps"));
  EXPECT_TRUE(std::filesystem::exists(made / "skin_curve.png"));
  EXPECT_FALSE(std::filesystem::exists(made / "curve.png"));  // the end of another name
}

TEST_F(PublishTest, PutsAComparisonOfTheSheetsModelsIntoItsPlace) {
  nlohmann::json small = testing::small_experiment();
  small["made_by"] = "fidelity";
  testing::write_text(project() / "docs/a.md", "e/fidelity.csv, e/fidelity.png");
  small["datasets"]["test"]["count"] = 5;
  small["datasets"]["validation"]["count"] = 2;
  testing::write_text(project() / "e.json", small.dump());
  SolverRegistry registry;
  const Experiment experiment = read_experiment(project() / "e.json", registry, chart_types());
  const auto run = testing::run_program(project(), "fidelity e.json --out results/e");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  EXPECT_EQ(publish_experiment(experiment, project(), Cache(project() / "cache"), 1), 0);
  const auto published = project() / "results/published/e";
  EXPECT_EQ(testing::read_text(published / "fidelity.csv"),
            testing::read_text(project() / "results/e/fidelity.csv"));
  // The picture has a palette: type 3 of PNG's header.
  const std::string picture = testing::read_text(published / "fidelity.png");
  ASSERT_GT(picture.size(), 26u);
  EXPECT_EQ(picture[25], 3);
  EXPECT_LE(picture.size(), most_picture_bytes);
  EXPECT_TRUE(std::filesystem::exists(published / "provenance.json"));
  EXPECT_FALSE(std::filesystem::exists(published / "summary.json"));
  // Without its figure it is not published, and what was published stays.
  const std::string drawn = testing::read_text(published / "fidelity.png");
  const testing::Environment no_gnuplot("PATH", (project() / "core").string());
  try {
    publish_experiment(experiment, project(), Cache(project() / "cache"), 1);
    FAIL() << "published without its figure";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("fidelity.svg could not be drawn"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(testing::read_text(published / "fidelity.png"), drawn);
  EXPECT_TRUE(std::filesystem::exists(published / "README.md.in"));
}

}  // namespace
}  // namespace ertbench
