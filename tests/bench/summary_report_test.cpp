// `ertbench report`: what a run reported, made once more of its summary.json alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::read_text;

/// A sweep, two sets, a paper's values, and every kind of chart; timed.
json charted_experiment() {
  json small = testing::small_experiment();
  small["title"] = "Small *experiment*";
  small["datasets"]["other"] = small["datasets"]["test"];
  small["datasets"]["other"]["seed"] = 9;
  small["solvers"][1] = {{"type", "tsvd"}, {"label", "svd"}, {"sweep", {{"rank", {20, 30}}}}};
  small["timing"] = {{"frames", 662}, {"batch", 8}, {"rounds", 1}};
  small["right_sizing"] = {{"margin", 0.2}};
  small["published"] = {{"source", "a paper"}, {"rows", {{"pdipm", {{"RIE", 0.05}}}}}};
  small["charts"] = {{{"type", "bars"}, {"name", "bars"}, {"dataset", "other"}},
                     {{"type", "speed-accuracy"}, {"name", "speed"}, {"solvers", {"svd", "pdipm"}}},
                     {{"type", "training-budget"}, {"name", "budget"}}};
  return small;
}

/// The words of a page, without its tags.
std::string words_of(const std::string& page) {
  return std::regex_replace(page, std::regex("<[^<>]*>"), "");
}

/// What stands on the page between two texts, with both.
std::string part_of_page(const std::string& page, const std::string& from, const std::string& to) {
  const std::size_t begin = page.find(from);
  if (begin == std::string::npos) return "";
  return page.substr(begin, page.find(to, begin) + to.size() - begin);
}

TEST(SummaryReport, IsThatOfTheRun) {
  const testing::TemporaryFolder folder("summary_report");
  testing::write_text(folder.path() / "e.json", charted_experiment().dump());
  const auto run = testing::run_program(folder.path(), "run e.json --out ran");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  // Nothing else is there to take anything from.
  const fs::path ran = folder.path() / "ran", out = folder.path() / "out";
  fs::create_directories(folder.path() / "kept");
  fs::copy_file(ran / "summary.json", folder.path() / "kept/summary.json");
  fs::remove_all(folder.path() / "cache");
  fs::remove(folder.path() / "e.json");
  const auto report = testing::run_program(folder.path(), "report kept --out out");
  ASSERT_EQ(report.exit_code, 0) << report.output;
  for (const char* name : {"summary.json", "table.md", "table.csv", "table.tex", "bars.svg",
                           "bars.png", "speed.svg", "speed.md", "speed_choices.csv", "budget.svg"})
    EXPECT_TRUE(read_text(ran / name) == read_text(out / name)) << name;
  const std::string page = read_text(out / "report.html"), whole = read_text(ran / "report.html");
  for (const char* title : {"<h2>Results: test</h2>", "<h2>Results: other</h2>",
                            "<h2>How to read the tables</h2>", "<h2>Provenance</h2>"}) {
    const std::string section = part_of_page(page, title, "</section>");
    EXPECT_FALSE(section.empty()) << title;
    EXPECT_EQ(section, part_of_page(whole, title, "</section>"));
  }
  for (const json& row : testing::summary_of(ran).at("rows"))
    EXPECT_NE(page.find(row.at("label").get<std::string>()), std::string::npos);
  EXPECT_NE(report.output.find("left out: differences, reconstructions; `./ertbench run e.json"),
            std::string::npos)
      << report.output;
}

TEST(SummaryReport, RefusesWhatIsNoResultAndWhatIsNoPlaceForIt) {
  const testing::TemporaryFolder folder("summary_report");
  const auto refused = [&](const std::string& arguments, const std::string& why) {
    const auto report = testing::run_program(folder.path(), "report " + arguments);
    EXPECT_EQ(report.exit_code, 2) << report.output;
    EXPECT_NE(report.output.find(why), std::string::npos) << report.output;
  };
  const fs::path good = ERTBENCH_SOURCE_DIR "/results/published/quick";
  fs::create_directories(folder.path() / "result");
  fs::create_directories(folder.path() / "taken");
  testing::write_text(folder.path() / "taken/letter.txt", "mine");
  const auto damaged = [&](const std::string& text, const std::string& why) {
    testing::write_text(folder.path() / "result/summary.json", text);
    refused("result --out out", why);
  };
  refused("result --out out", "result: there is no summary.json; name the folder of a result");
  damaged(read_text(good / "summary.json").substr(0, 3000), "result/summary.json: ");
  json summary = testing::summary_of(good);
  for (const char* key : {"build", "parameters"}) {
    json other = summary;
    other["rows"][2][key] = 5;
    damaged(other.dump(), std::string("result/summary.json: /rows/2/") + key);
  }
  json newer = summary;
  newer["schema"] = 2;
  damaged(newer.dump(), "result/summary.json: /schema: must be");
  summary["rows"][2].erase("metrics");
  damaged(summary.dump(), "result/summary.json: /rows/2/metrics");
  summary["presentation"]["charts"] = {{{"type", "pie"}, {"name", "a"}}};
  damaged(summary.dump(), "result/summary.json: /presentation/charts/0/type");
  summary.erase("provenance");
  summary.erase("presentation");
  damaged(summary.dump(), "result/summary.json: /provenance");
  refused("'" + good.string() + "' --out taken", "--out taken: there are files already");
  refused("'" + good.string() + "' --out taken/letter.txt", "there are files already");
  EXPECT_EQ(read_text(folder.path() / "taken/letter.txt"), "mine");
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST(SummaryReport, CanBeMadeOfEveryPublishedSummary) {
  const testing::TemporaryFolder folder("summary_report");
  int reports = 0;
  for (const auto& entry : fs::directory_iterator(ERTBENCH_SOURCE_DIR "/results/published")) {
    if (!fs::exists(entry.path() / "summary.json")) continue;
    const std::string name = entry.path().filename().string();
    const auto report =
        testing::run_program(folder.path(), "report '" + entry.path().string() + "' --out " + name);
    ASSERT_EQ(report.exit_code, 0) << report.output;
    ++reports;
    const std::string page = words_of(part_of_page(read_text(folder.path() / name / "report.html"),
                                                   "<h2>Results", "<h2>How to read"));
    const json rows = testing::summary_of(entry.path()).at("rows");
    for (const json& row : rows)
      ASSERT_NE(page.find(row.at("label").get<std::string>()), std::string::npos) << name;
    // What a chart recommends was published beside the summary.
    for (const auto& file : fs::directory_iterator(entry.path())) {
      const fs::path choices = file.path().filename();
      if (!choices.string().ends_with("_choices.csv")) continue;
      EXPECT_TRUE(read_text(file.path()) == read_text(folder.path() / name / choices)) << choices;
    }
    // A line of titles and one for each row; no cell of a published row breaks a line.
    const std::string table = read_text(folder.path() / name / "table.csv");
    EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), std::ssize(rows) + 1) << name;
  }
  EXPECT_GT(reports, 25);
}

}  // namespace
}  // namespace ertbench
