#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "bench/ladder/ladder_results.h"
#include "bench/table/table.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"
#include "tests/bench/figure_testing.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using testing::TemporaryFolder;

json with_axis(const json& axis) {
  json object = testing::small_experiment();
  object["ladders"] = {{"axes", json::array({axis})}};
  return object;
}

Experiment read(const json& object) {
  const TemporaryFolder folder("ladder");
  testing::write_text(folder / "x.json", object.dump());
  SolverRegistry registry;
  return read_experiment(folder / "x.json", registry, {});
}

std::string refusal_of(const json& axis) {
  try {
    read(with_axis(axis));
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Ladder, LetsConditionsWorsenTogether) {
  json axis = {{"name", "combined"},
               {"scale", "categories"},
               {"levels", {"mild", "severe"}},
               {"vary",
                {{"/snr_db", {60, 40}},
                 {"/faults/dead_electrodes", {0, 1}},
                 {"/faults/background_change", {-0.02, -0.05}}}}};
  const Experiment experiment = read(with_axis(axis));
  const Ladders& ladders = *experiment.ladders;
  const LadderAxis& read_axis = ladders.axes[0];
  const DatasetSpec severe = dataset_at(ladders, experiment.sensor, read_axis, read_axis.levels[1]);
  EXPECT_EQ(severe.noise.snr_db, 40);
  EXPECT_EQ(severe.faults.dead_electrodes, 1);
  EXPECT_EQ(severe.faults.background_change, -0.05);
  EXPECT_EQ(dataset_at(ladders, experiment.sensor, read_axis, read_axis.levels[0]).noise.snr_db,
            60);
  axis["vary"]["/snr_db"] = {60};
  EXPECT_NE(refusal_of(axis).find("as many values as there are"), std::string::npos);
  axis["vary"]["/snr_db"] = {60, 40};
  axis.erase("scale");
  EXPECT_NE(refusal_of(axis).find("categories"), std::string::npos);
}

/// A level at which the first `failures` of 100 frames are undefined.
LadderLevel level_of(const Level& level, int failures) {
  LadderLevel out{level, std::vector<JudgedFrame>(100), ""};
  for (int f = 0; f < failures; ++f) {
    out.frames[static_cast<std::size_t>(f)].failed = static_cast<int>(FailureKind::undefined);
  }
  return out;
}

TEST(Ladder, HalvesTheStepInWhichItBreaks) {
  LadderAxis axis;
  axis.levels = {80.0, 60.0, 40.0, 20.0};
  int calls = 0;
  const auto levels = climb_ladder(axis, 0.05, [&](const Level& level) {
    ++calls;
    return level_of(level, level.number() < 47.3 ? 50 : 0);
  });
  EXPECT_EQ(calls, 4 + 6);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    EXPECT_LT(levels[i].level.number(), levels[i - 1].level.number());
    if (levels[i].share() > 0.05 && levels[i - 1].share() == 0) {
      EXPECT_NEAR(levels[i].level.number(), 47.3, 20.0 / 64);
      EXPECT_NEAR(levels[i - 1].level.number() - levels[i].level.number(), 20.0 / 64, 1e-12);
    }
  }
}

TEST(Ladder, TakesGeometricMeansAndWholeNumbers) {
  LadderAxis axis;
  axis.levels = {0.01, 1.0};
  axis.logarithmic = true;
  const auto by_size = [](double limit) {
    return [limit](const Level& level) { return level_of(level, level.number() > limit ? 50 : 0); };
  };
  const auto smooth = climb_ladder(axis, 0.05, by_size(0.5));
  EXPECT_NEAR(smooth[1].level.number(), 0.1, 1e-12);
  axis = {};
  axis.levels = {1, 8};
  axis.integer = true;
  const auto whole = climb_ladder(axis, 0.05, by_size(5));
  std::vector<double> numbers;
  for (const LadderLevel& level : whole) numbers.push_back(level.level.number());
  EXPECT_EQ(numbers, (std::vector<double>{1, 4, 5, 6, 8}));
  // By geometric means too, whose whole parts may be the ends themselves.
  axis.logarithmic = true;
  const auto in_steps = climb_ladder(axis, 0.05, by_size(5));
  numbers.clear();
  for (const LadderLevel& level : in_steps) numbers.push_back(level.level.number());
  EXPECT_EQ(numbers, (std::vector<double>{1, 2, 4, 5, 6, 8}));
  axis.levels = {4, 2};
  const auto down = climb_ladder(
      axis, 0.05, [&](const Level& level) { return level_of(level, level.number() < 4 ? 50 : 0); });
  ASSERT_EQ(down.size(), 3u);
  EXPECT_EQ(down[1].level.number(), 3);
  axis.logarithmic = false;
  axis.levels = {1, 8};
  // Nothing to be found between levels where none or all fail.
  EXPECT_EQ(climb_ladder(axis, 0.05, by_size(9)).size(), 2u);
  EXPECT_EQ(climb_ladder(axis, 0.05, by_size(0)).size(), 2u);
}

TEST(Ladder, LevelsArePairedVariantsOfTheTestSet) {
  const Experiment experiment =
      read(with_axis({{"name", "radius"}, {"vary", "/scenes/radius"}, {"levels", {0.2, 0.1}}}));
  const LadderAxis& axis = experiment.ladders->axes.front();
  const DatasetSpec large =
      dataset_at(*experiment.ladders, experiment.sensor, axis, axis.levels[0]);
  const DatasetSpec little =
      dataset_at(*experiment.ladders, experiment.sensor, axis, axis.levels[1]);
  EXPECT_EQ(to_json(large), to_json(experiment.tests.front())) << "0.2 is the base set's";
  for (std::uint64_t s = 0; s < 5; ++s) {
    const Contact a = large.scene(s).contacts.front();
    const Contact b = little.scene(s).contacts.front();
    EXPECT_EQ(b.half_size.x(), 0.1);
    EXPECT_NEAR(a.centre.x() / 0.8, b.centre.x() / 0.9, 1e-12) << "same draw, other room";
    RandomStream first = large.noise_stream(s);
    RandomStream second = little.noise_stream(s);
    EXPECT_EQ(first.bits(), second.bits());
  }
}

TEST(Ladder, ParametersGoIntoTheEntry) {
  const Experiment experiment = read(with_axis({{"name", "rank"},
                                                {"solver", "tsvd"},
                                                {"vary", "/rank"},
                                                {"levels", {1, 30, 208}},
                                                {"integer", true}}));
  const LadderAxis& axis = experiment.ladders->axes.front();
  EXPECT_TRUE(axis.concerns(experiment.solvers[1]));
  EXPECT_FALSE(axis.concerns(experiment.solvers[0]));
  const SolverEntry entry = entry_at(experiment.solvers[1], axis, 208);
  EXPECT_EQ(entry.spec->at("rank"), 208);
  EXPECT_FALSE(training_at(*experiment.ladders, experiment.sensor, axis, 208));
}

TEST(Ladder, SaysWhatIsWrong) {
  const json axis = {{"name", "snr"}, {"vary", "/snr_db"}, {"levels", {80, 40}}};
  EXPECT_EQ(refusal_of(axis), "accepted");
  const auto with = [&](const char* key, const json& value) {
    json changed = axis;
    changed[key] = value;
    return refusal_of(changed);
  };
  EXPECT_NE(with("levels", {40, 80, 60}).find("/ladders/axes/0/levels: must rise, or fall"),
            std::string::npos);
  EXPECT_NE(with("vary", "/snr").find("snr"), std::string::npos);
  EXPECT_NE(with("vary", "snr_db").find("leads nowhere"), std::string::npos);
  EXPECT_NE(with("vary", "train:/count").find("name the \"solver\""), std::string::npos);
  EXPECT_NE(with("levels", {"a", "b"}).find("\"scale\": \"categories\""), std::string::npos);
  EXPECT_NE(with("solver", "nobody").find("no solver is labelled \"nobody\""), std::string::npos);
  EXPECT_NE(with("solver", "tsvd").find("no parameter of tsvd"), std::string::npos);
  EXPECT_NE(with("levels", {-1, -300}).find("level 1, -300, makes what cannot be used"),
            std::string::npos);
  EXPECT_NE(with("scal", "log").find("scale"), std::string::npos);
}

TEST(Ladder, LevelsAreNumbersTextsOrWhateverTheFileHas) {
  EXPECT_EQ(Level(40).text(), "40");
  EXPECT_EQ(Level(0.06).text(), "0.06");
  EXPECT_EQ(Level(json("ring")).text(), "ring");
  EXPECT_EQ(Level(json{"disc", "ring"}).text(), "disc, ring");
  EXPECT_EQ(Level(json{{"mean", 2}}).text(), "{\"mean\":2}");
  EXPECT_EQ(Level(40), Level(40.0)) << "compared as numbers";
  EXPECT_NE(Level(40), Level(json("40")));
  EXPECT_FALSE(Level(json("40")).is_number());
  EXPECT_THROW(Level(json("40")).number(), std::logic_error);
  EXPECT_TRUE(Level().json().is_null());
}

TEST(Ladder, LevelsHaveThreeDigits) {
  EXPECT_EQ(level_digits(8), "8");
  EXPECT_EQ(level_digits(27.34), "27.3");
  EXPECT_EQ(level_digits(0.0451), "0.0451");
  EXPECT_EQ(level_digits(2.613e-8), "2.61e-08");
}

TEST(Ladder, TablesSayWhatIsKnown) {
  const Experiment experiment = read([] {
    json object =
        with_axis({{"name", "snr"}, {"unit", "dB"}, {"vary", "/snr_db"}, {"levels", {80, 60, 40}}});
    object["ladders"]["axes"].push_back({{"name", "shape"},
                                         {"vary", "/scenes/shapes"},
                                         {"scale", "categories"},
                                         {"levels", {{"disc"}, {"ring"}}}});
    return object;
  }());
  LadderOutcome good{&experiment.solvers[0], LadderRecord{}, ""};
  good.record->base = level_of({}, 1);
  good.record->axes = {{"snr", {level_of(80, 0), level_of(60, 0), level_of(40, 10)}},
                       {"shape", {level_of(json{"disc"}, 0), level_of(json{"ring"}, 25)}}};
  const LadderOutcome bad{&experiment.solvers[1], std::nullopt, "crashed: Aborted, core, dumped"};
  const auto lines = breakdowns_of(*experiment.ladders, {good, bad});
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_EQ(lines[0].state, "breaks");
  EXPECT_EQ(lines[0].breakdown->level, 50);
  EXPECT_EQ(lines[1].categories, "disc 0.0 %, ring 25.0 %");
  EXPECT_EQ(lines[3].state, bad.failure);
  const std::string csv = csv_of(breakdown_data(lines));
  EXPECT_NE(csv.find("one-step-gn,snr,,50,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("tsvd,shape,,,,,,\"crashed: Aborted, core, dumped\",0,,\n"), std::string::npos)
      << csv;
  EXPECT_NE(
      csv_of(levels_data({good, bad})).find("one-step-gn,snr,40,100,0.1,0.1,0,0,0,0,0,0,,,,\n"),
      std::string::npos)
      << csv_of(levels_data({good, bad}));
}

class LadderChartTest : public testing::FigureTest {
 protected:
  /// Of so many solvers "m1", "m2", ..., whose frames fail the sooner the later they stand.
  std::string svg_of(int solvers) {
    Ladders ladders;
    LadderAxis axis;
    axis.name = "noise";
    axis.title = "Noise";
    axis.unit = "dB";
    for (const int level : {80, 60, 40, 20}) axis.levels.emplace_back(level);
    std::vector<SolverEntry> entries(static_cast<std::size_t>(solvers));
    std::vector<LadderOutcome> outcomes;
    for (int s = 0; s < solvers; ++s) {
      SolverEntry& entry = entries[static_cast<std::size_t>(s)];
      entry.label = "m" + std::to_string(s + 1);
      LadderClimb climb{axis.name, {}};
      for (const Level& level : axis.levels) {
        LadderLevel step{level, std::vector<JudgedFrame>(20), ""};
        for (std::size_t f = 0; f < step.frames.size(); ++f) {
          JudgedFrame& frame = step.frames[f];
          frame.error =
              0.1 * (1 + s) * std::exp((80 - level.number()) / 30) * (1 + 0.02 * double(f));
          if (*frame.error > 1) frame.failed = static_cast<int>(FailureKind::worse_than_nothing);
        }
        climb.levels.push_back(std::move(step));
      }
      outcomes.push_back({&entry, LadderRecord{{}, {std::move(climb)}}, ""});
    }
    draw_ladder_chart(ladders, axis, outcomes, results() / "chart");
    return read("chart.svg");
  }
};

TEST_F(LadderChartTest, MoreThanSevenSolversStandInSeveralColumns) {
  for (const auto& [solvers, columns] : {std::pair(7, 1U), std::pair(8, 2U), std::pair(15, 3U)}) {
    SCOPED_TRACE(solvers);
    const std::string svg = svg_of(solvers);
    EXPECT_EQ(testing::count(svg, "level (dB)"), columns);
    EXPECT_EQ(testing::count(svg, "failing frames"), 1U) << "the same axis for all columns";
    for (int s = 1; s <= solvers; ++s) {
      EXPECT_EQ(testing::count(svg, ">m" + std::to_string(s) + "<"), 1U) << s;
    }
  }
}

}  // namespace
}  // namespace ertbench
