// Ladders as users climb them: the program itself, its tables recomputed from its records.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <sstream>

#include "tests/bench/small_experiment.h"

namespace ertbench::testing {
namespace {

using nlohmann::json;

json experiment_with_ladders() {
  json object = small_experiment();
  object["datasets"]["test"]["snr_db"] = 60;
  object["solvers"] = json::parse(R"([{"type": "one-step-gn", "lambda": "auto"},
                                      {"type": "tsvd", "rank": 30}])");
  object["ladders"] = json::parse(R"({
    "axes": [
      {"name": "snr", "unit": "dB", "vary": "/snr_db", "levels": [70, 50, 30, 10]},
      {"name": "shape", "vary": "/scenes/shapes", "scale": "categories",
       "levels": [["disc"], ["ring"]]},
      {"name": "rank", "solver": "tsvd", "vary": "/rank", "integer": true,
       "levels": [1, 30, 104, 208]}
    ]
  })");
  return object;
}

/// Lines of a CSV file whose fields hold no commas, by their header's names.
std::vector<std::map<std::string, std::string>> csv_lines(const fs::path& file) {
  std::istringstream in(read_text(file));
  const auto fields = [](const std::string& line) {
    std::vector<std::string> out(1);
    for (const char c : line) {
      if (c == ',') {
        out.emplace_back();
      } else {
        out.back() += c;
      }
    }
    return out;
  };
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> names = fields(line);
  std::vector<std::map<std::string, std::string>> lines;
  while (std::getline(in, line)) {
    const std::vector<std::string> values = fields(line);
    auto& entry = lines.emplace_back();
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) {
      entry[names[i]] = values[i];
    }
  }
  return lines;
}

std::map<std::string, std::string> line_of(const fs::path& file, const std::string& solver,
                                           const std::string& axis, const std::string& side = "") {
  for (const auto& line : csv_lines(file)) {
    if (line.at("solver") == solver && line.at("axis") == axis && line.at("side") == side) {
      return line;
    }
  }
  return {};
}

std::map<std::string, std::string> axis_line(const fs::path& file, const std::string& solver,
                                             const std::string& axis) {
  for (const auto& line : csv_lines(file)) {
    if (line.at("solver") == solver && line.at("axis") == axis) return line;
  }
  return {};
}

/// The share of frames that fail by the rule, from the raw numbers and not from "failed".
double share_of(const json& level) {
  const std::size_t frames = level.at("failed").size();
  int failed = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    const json& error = level.at("error").at(f);
    const json& distance = level.at("distance").at(f);
    failed += level.at("status").at(f) == 2 || error.is_null() || error.get<double>() >= 1 ||
              (!distance.is_null() && distance.get<double>() > 0.25);
  }
  return failed / static_cast<double>(frames);
}

/// "failing,detected,good,false_alarms" over the levels of an axis, from the raw numbers.
std::string detection_of(const json& levels) {
  std::array<int, 4> counts{};
  for (const json& level : levels) {
    for (std::size_t f = 0; f < level.at("failed").size(); ++f) {
      const std::size_t kind = level.at("failed").at(f) == 0 ? 2 : 0;
      ++counts[kind];
      counts[kind + 1] += level.at("status").at(f) != 0;
    }
  }
  return std::to_string(counts[0]) + "," + std::to_string(counts[1]) + "," +
         std::to_string(counts[2]) + "," + std::to_string(counts[3]);
}

TEST(LadderProgram, TablesFollowFromTheRecords) {
  const TemporaryFolder folder("ladders");
  write_text(folder / "x.json", experiment_with_ladders().dump());
  const Outcome outcome = run_program(folder.path(), "run x.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const fs::path results = folder / "results" / "x";
  for (const char* file :
       {"breakdown.md", "breakdown.svg", "breakdown.png", "levels.csv", "detection.md",
        "ladder_snr.svg", "ladder_shape.png", "ladder_rank.svg"}) {
    EXPECT_TRUE(fs::exists(results / file)) << file;
  }
  EXPECT_NE(read_text(results / "report.html").find("Where it fails"), std::string::npos);
  for (const std::string solver : {"one-step-gn", "tsvd"}) {
    SCOPED_TRACE(solver);
    const json record = json::parse(read_text(results / "records" / (solver + ".ladders.json")));
    const json& levels = record.at("axes").at(0).at("levels");
    ASSERT_EQ(levels.size(), 4u + 6u);
    double level = NAN;
    for (std::size_t i = 1; i < levels.size() && std::isnan(level); ++i) {
      const double before = share_of(levels[i - 1]);
      const double here = share_of(levels[i]);
      if (here <= 0.05) continue;
      const double a = levels[i - 1].at("level");
      const double b = levels[i].at("level");
      level = a + (b - a) * (0.05 - before) / (here - before);
    }
    const auto line = line_of(results / "breakdown.csv", solver, "snr");
    EXPECT_EQ(line.at("state"), "breaks");
    EXPECT_NEAR(std::stod(line.at("level")), level, 1e-4 * level);
    EXPECT_LE(std::stod(line.at("ci_low")), level);
    EXPECT_GE(std::stod(line.at("ci_high")), level);
    EXPECT_NEAR(std::stod(line.at("share_at_default")), share_of(record.at("base")), 1e-5);

    const auto noticed = axis_line(results / "detection.csv", solver, "snr");
    EXPECT_EQ(noticed.at("failing") + "," + noticed.at("detected") + "," + noticed.at("good") +
                  "," + noticed.at("false_alarms"),
              detection_of(levels));
    EXPECT_LE(std::stod(noticed.at("detection_low")), std::stod(noticed.at("detection_rate")));
    EXPECT_FALSE(axis_line(results / "detection.csv", solver, "default").empty());
  }
  // One value of the parameter works; a rank of 208 is refused, which is its level's failure.
  const json record = json::parse(read_text(results / "records" / "tsvd.ladders.json"));
  const json& ranks = record.at("axes").at(2).at("levels");
  EXPECT_NE(ranks.at(3).at("message").get<std::string>().find("/rank"), std::string::npos);
  EXPECT_EQ(line_of(results / "breakdown.csv", "tsvd", "rank", "above").at("state"), "breaks");
  EXPECT_TRUE(line_of(results / "breakdown.csv", "one-step-gn", "rank").empty());

  // What is finished is not done again; another rule is another record.
  const auto written = fs::last_write_time(results / "records" / "tsvd.ladders.json");
  ASSERT_EQ(run_program(folder.path(), "run x.json").exit_code, 0);
  EXPECT_EQ(fs::last_write_time(results / "records" / "tsvd.ladders.json"), written);
  json stricter = experiment_with_ladders();
  stricter["ladders"]["failure"] = {{"relative_error", 0.01}};
  write_text(folder / "x.json", stricter.dump());
  ASSERT_EQ(run_program(folder.path(), "run x.json").exit_code, 0);
  EXPECT_EQ(line_of(results / "breakdown.csv", "tsvd", "snr").at("state"),
            "fails at its mildest level");
}

TEST(LadderProgram, ParametersAndTrainingSetsAreFittedAnewAndKept) {
  const TemporaryFolder folder("fitted_ladders");
  json object = small_experiment();
  object["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  object["datasets"]["train"] = object["datasets"]["validation"];
  object["solvers"] = json::parse(R"([{"type": "toy-learned", "label": "toy", "seed": 1}])");
  object["ladders"] = json::parse(R"({"axes": [
    {"name": "seeds", "solver": "toy", "vary": "/seed", "scale": "categories", "levels": [1, 2, 3]},
    {"name": "count", "solver": "toy", "vary": "train:/count", "levels": [30, 10]}
  ]})");
  write_text(folder / "x.json", object.dump());
  for (int run = 0; run < 2; ++run) {
    const Outcome outcome = run_program(folder.path(), "run x.json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    // Seed 1 on 30 scenes is the experiment's own; seeds 2 and 3, and 10 scenes, are new.
    EXPECT_EQ(read_text(folder / "cache" / "solvers" / "fits"), "fit\nfit\nfit\nfit\n");
    fs::remove_all(folder / "results");
  }
}

TEST(LadderProgram, ASolverThatMisbehavesCostsItsRowAlone) {
  const TemporaryFolder folder("bad_ladders");
  json object = experiment_with_ladders();
  object["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  object["solvers"].push_back({{"type", "misbehaving"}, {"label", "crash"}, {"how", "crash"}});
  object["solvers"].push_back({{"type", "misbehaving"}, {"label", "nan"}, {"how", "nan"}});
  write_text(folder / "x.json", object.dump());
  const Outcome outcome = run_program(folder.path(), "run x.json");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  const fs::path table = folder / "results" / "x" / "breakdown.csv";
  EXPECT_EQ(line_of(table, "tsvd", "snr").at("state"), "breaks");
  EXPECT_NE(line_of(table, "crash", "snr").at("state").find("crashed"), std::string::npos);
  EXPECT_EQ(line_of(table, "nan", "snr").at("state"), "fails at its mildest level");
  EXPECT_NE(read_text(folder / "results" / "x" / "report.html").find("crashed"), std::string::npos);
}

}  // namespace
}  // namespace ertbench::testing
