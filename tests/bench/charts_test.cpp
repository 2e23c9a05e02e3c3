#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <tuple>

#include "bench/plot/palette.h"
#include "bench/report/bar_chart.h"
#include "bench/report/chart.h"
#include "bench/report/heat_map.h"
#include "bench/training/training_chart.h"
#include "core/errors.h"
#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using testing::count;

class Charts : public testing::FigureTest {
 protected:
  /// Both files are there and whole.
  std::string svg(const std::string& name) const {
    EXPECT_EQ(read(name + ".png").substr(0, 8), "\x89PNG\r\n\x1a\n");
    const std::string text = read(name + ".svg");
    EXPECT_NE(text.find("</svg>"), std::string::npos);
    return text;
  }
};

ResultRow made_row(const std::string& label, double ar, double error) {
  ResultRow row;
  row.label = label;
  row.type = "dd-ert";
  row.dataset = "test";
  for (const Metric metric : kMetrics) {
    row.metrics[metric] = {0.5, Interval{0.4, 0.6}, 0.5, 10, 0};
  }
  row.metrics[Metric::AR] = {ar, Interval{ar - 0.02, ar + 0.02}, ar, 10, 0};
  row.metrics[Metric::relative_error].mean = error;
  return row;
}

ResultRow truth() {
  ResultRow row = made_row("truth", 1, 0);
  row.type = "truth";
  row.metrics[Metric::RES].mean = 82.78;
  return row;
}

BarChart bars(std::vector<std::string> labels) {
  return {
      {"ablation", "test"}, std::move(labels), {Metric::AR, Metric::RES, Metric::PE, Metric::RIE}};
}

TEST_F(Charts, BarsShowEveryVariantAndItsValue) {
  const std::vector<ResultRow> rows = {truth(), made_row("L1", 0.9, 0.7),
                                       made_row("L1 + adversarial", 1.123, 0.6)};
  const BarChart chart = bars({"L1", "L1 + adversarial"});
  const Bars shown = chart.bars_of(rows, "Ablation");
  ASSERT_EQ(shown.panels.size(), 4u);
  EXPECT_EQ(shown.panels[0].ideal, 1);
  EXPECT_EQ(shown.panels[1].ideal, 82.78);
  EXPECT_EQ(shown.panels[2].ideal, 0);
  chart.draw(rows, "Ablation", results());
  const std::string text = svg("ablation");
  for (const char* word : {"Ablation", "(a)", "(b)", "0.900", "1.123", "truth 82.78", "ideal 1",
                           "adversarial", "95 %"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(count(text, "<title>"), 2u * 4u);
  EXPECT_EQ(count(text, "L1 + adversarial\nAR: 1.123, 95 % interval 1.103 to 1.143<"), 1u);
}

TEST_F(Charts, BarsKeepWhatFailedOrIsMissing) {
  ResultRow failed;
  failed.label = "frozen";
  failed.dataset = "test";
  failed.status = "timed out";
  ResultRow diverged = made_row("random", 3, 2);
  diverged.status = "diverged";
  ResultRow undefined = made_row("empty", 0, 1);
  undefined.metrics[Metric::PE] = {};
  const std::vector<ResultRow> rows = {failed, diverged, undefined};
  bars({"frozen", "random", "empty", "absent"}).draw(rows, "Ablation", results());
  const std::string text = svg("ablation");
  EXPECT_GE(count(text, "timed out"), 4u);
  EXPECT_GE(count(text, "not run"), 4u);
  EXPECT_NE(text.find("(diverged)"), std::string::npos);
  EXPECT_NE(text.find("3.000"), std::string::npos);
  EXPECT_EQ(count(text, ">undefined<"), 1u);
}

TEST_F(Charts, BarsOfManyVariantsAndOfNone) {
  std::vector<ResultRow> rows = {truth()};
  std::vector<std::string> labels;
  for (int i = 0; i < 24; ++i) {
    labels.push_back("dd-ert alpha=0.000" + std::to_string(i));
    rows.push_back(made_row(labels.back(), 1 + 0.01 * i, 0.5));
  }
  bars(labels).draw(rows, "Many", results());
  EXPECT_EQ(count(svg("ablation"), ">dd-ert alpha=0.0007<"), 4u);
  bars({"absent"}).draw({}, "None", results());
  EXPECT_NE(svg("ablation").find("not run"), std::string::npos);
  EXPECT_THROW(draw_bars({}, results() / "x"), std::invalid_argument);
}

/// A sweep of alpha and beta over powers of ten, the least error at (0.01, 1).
struct Sweep {
  std::vector<ResultRow> rows;
  std::vector<std::string> labels;
  HeatMapChart::Optimum published = {nlohmann::json(0.001), nlohmann::json(0.1)};

  Sweep() {
    for (const double alpha : {0.01, 0.001, 10.0}) {
      for (const double beta : {0.1, 1.0}) {
        const double error = 0.5 + std::abs(alpha - 0.01) + std::abs(beta - 1);
        ResultRow row = made_row("net " + std::to_string(rows.size()), 1 + error / 10, error);
        row.sweep = nlohmann::json{{"alpha", alpha}, {"beta", beta}};
        labels.push_back(row.label);
        rows.push_back(std::move(row));
      }
    }
  }
  HeatMapChart chart() const {
    return {{"alpha_beta", "test"}, labels, {Metric::AR, Metric::PE}, published};
  }
  ResultRow& at(std::size_t alpha, std::size_t beta) { return rows[2 * alpha + beta]; }
};

TEST_F(Charts, HeatMapMarksThePapersChoiceAndTheBest) {
  const Sweep sweep;
  const HeatMap map = sweep.chart().map_of(sweep.rows, "Weights");
  EXPECT_EQ(map.x_name, "alpha");
  EXPECT_EQ(map.x_values, (std::vector<std::string>{"0.001", "0.01", "10"}));  // sorted
  EXPECT_EQ(map.y_values, (std::vector<std::string>{"0.1", "1"}));
  ASSERT_TRUE(map.published && map.best);
  EXPECT_EQ(std::pair(map.published->x, map.published->y), std::pair(0, 0));
  EXPECT_EQ(std::pair(map.best->x, map.best->y), std::pair(1, 1));
  // AR is coloured by its distance from one.
  EXPECT_NEAR(map.panels[0].colours[4].value(), 0.05, 1e-12);
  EXPECT_NEAR(map.panels[0].values[4].value(), 1.05, 1e-12);
  sweep.chart().draw(sweep.rows, "Weights", results());
  const std::string text = svg("alpha_beta");
  for (const char* word : {"1.050", "alpha", "best here: alpha = 0.01, beta = 1", "|AR − 1|",
                           "choice: alpha = 0.001, beta = 0.1"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(count(text, "<title>"), 6u * 2u);
  EXPECT_EQ(count(text, "<title>alpha = 0.01, beta = 1\nAR: 1.050; |AR − 1|: 0.050<"), 1u);

  // Values that say themselves what they are need no names.
  HeatMap unnamed = map;
  unnamed.x_name = unnamed.y_name = "";
  draw_heat_map(unnamed, results() / "unnamed");
  EXPECT_EQ(count(svg("unnamed"), "<title>0.01, 1\nAR: 1.050; |AR − 1|: 0.050<"), 1u);
}

TEST_F(Charts, HeatMapCrossesOutWhatFailedAndTakesTheBestOfTheRest) {
  Sweep sweep;
  sweep.at(0, 1).status = "diverged";
  sweep.at(2, 0).status = "not run";
  sweep.at(2, 0).metrics = {};
  sweep.published = {nlohmann::json(0.5), nlohmann::json(0.1)};
  const HeatMap map = sweep.chart().map_of(sweep.rows, "Weights");
  EXPECT_EQ(std::pair(map.best->x, map.best->y), std::pair(0, 1));
  EXPECT_FALSE(map.published);
  sweep.chart().draw(sweep.rows, "Weights", results());
  const std::string text = svg("alpha_beta");
  EXPECT_EQ(count(text, ">diverged<"), 2u);
  EXPECT_EQ(count(text, ">not run<"), 2u);
  EXPECT_NE(text.find("not on this grid"), std::string::npos);
}

TEST_F(Charts, HeatMapWithoutAnyResultSaysSo) {
  Sweep sweep;
  for (ResultRow& row : sweep.rows) {
    row.status = "not run";
    row.metrics = {};
  }
  sweep.chart().draw(sweep.rows, "Weights", results());
  EXPECT_EQ(count(svg("alpha_beta"), "no results yet"), 2u);
}

TEST_F(Charts, HeatMapOfASweepThatIsLarge) {
  HeatMap map;
  map.x_name = map.y_name = "value";
  for (int i = 0; i < 50; ++i) map.x_values.push_back(std::to_string(i));
  map.y_values = map.x_values;
  map.statuses.resize(2500);
  HeatMapPanel panel{"PE", "PE", 4, {}, {}};
  for (int i = 0; i < 2500; ++i) panel.values.push_back(i == 7 ? 1e9 : i * 1e-3);
  panel.colours = panel.values;
  map.panels = {panel};
  draw_heat_map(map, results() / "large");
  // One cell that is far off does not pale the others: the scale ends at four times the median.
  EXPECT_NE(svg("large").find("≥ "), std::string::npos);
  EXPECT_EQ(testing::drawn(svg("large")).find("1.00e+09"), std::string::npos);
  EXPECT_EQ(count(svg("large"), "value = 7, value = 0\nPE: 1.00e+09<"), 1U);
  map.panels[0].values.pop_back();
  EXPECT_THROW(draw_heat_map(map, results() / "large"), std::invalid_argument);
}

/// Who goes from one chart to the next finds the methods as they were.
TEST(MethodStyles, AMethodLooksTheSameInEveryCompany) {
  const std::vector<std::string> few{"fcnn", "mine", "contacts disc"};
  const std::vector<std::string> many{"one-step-gn", "contacts", "contacts disc", "fcnn", "fcnn-2"};
  const MethodStyles a(few);
  const MethodStyles b(many);
  EXPECT_EQ(a.line(0).text(), b.line(3).text());
  EXPECT_EQ(a.mark(0).text(), b.mark(3).text());
  EXPECT_EQ(a.colour(2).hex(), b.colour(1).hex());
  // Another's method takes nobody's place, whatever its name begins with.
  EXPECT_NE(b.colour(4).hex(), b.colour(3).hex());
  EXPECT_NE(a.colour(1).hex(), a.colour(0).hex());
  EXPECT_NE(a.colour(1).hex(), a.colour(2).hex());
}

TEST(MethodStyles, AllInOneChartAreToldApart) {
  std::vector<std::string> labels{"contacts", "contacts disc", "contacts level", "tsvd", "tsvd x"};
  for (int i = 0; i < 10; ++i) labels.push_back("plugin " + std::to_string(i));
  const MethodStyles styles(labels);
  std::set<std::tuple<std::string, int, int>> all;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    all.emplace(styles.colour(i).hex(), styles.line(i).dash, styles.mark(i).shape);
  }
  EXPECT_EQ(all.size(), labels.size());
}

TEST(Palette, RisesInLightnessAndSpansTheScreen) {
  for (int i = 1; i <= 20; ++i) {
    EXPECT_GT(viridis(i / 20.0).lightness(), viridis((i - 1) / 20.0).lightness());
  }
  EXPECT_EQ(viridis(0).hex(), "#440154");
  EXPECT_EQ(viridis(2).hex(), "#fde725");
  EXPECT_EQ(viridis(1).number(), 0xfde725);
  EXPECT_NEAR(Colour({1, 1, 1}).lightness(), 1, 1e-9);
  EXPECT_EQ(hue(0).towards_white(1).hex(), "#ffffff");
}

/// 4.5 to 1 is what WCAG 2 asks of texts: on white a luminance of 0.183, a lightness of 0.499.
TEST(Palette, TextsAreDarkEnoughToRead) {
  for (std::size_t i = 0; i < hues; ++i) {
    const Colour text = hue(i).for_text();
    EXPECT_LE(text.lightness(), 0.499) << i;
    if (hue(i).lightness() < 0.48) {
      EXPECT_EQ(text.hex(), hue(i).hex()) << i;
    }
  }
  EXPECT_GT(Colour({1, 1, 1}).for_text().lightness(), 0.4) << "no darker than it must be";
}

/// Logs of training.
class Training : public Charts {
 protected:
  void log(const std::string& name, const std::string& text) const {
    std::ofstream(results() / name) << text;
  }
  std::string refusal(const std::string& text) const {
    log("bad.csv", text);
    try {
      read_training_curves(results() / "bad.csv");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(Training, IsReadByTheNamesOfItsColumns) {
  log("a.csv", "epoch,loss,validation_error\n1,0.5,0.9\n2,nan,0.8\n3,0.1");
  const TrainingCurves curves = read_training_curves(results() / "a.csv");
  EXPECT_EQ(curves.columns, (std::vector<std::string>{"epoch", "loss", "validation_error"}));
  ASSERT_EQ(curves.epochs(), 2u);  // the third is not finished
  EXPECT_TRUE(std::isnan(curves.values[1][1]));
  EXPECT_EQ(curves.values[2][1], 0.8);
}

TEST_F(Training, WhatIsNoLogIsRefusedWithItsLine) {
  EXPECT_NE(refusal("").find("bad.csv: line 1"), std::string::npos);
  EXPECT_NE(refusal("loss,epoch\n").find("\"epoch\" first"), std::string::npos);
  EXPECT_NE(refusal("epoch,loss\n1,2\n2\n").find("line 3: must hold 2 numbers"), std::string::npos);
  EXPECT_NE(refusal("epoch,loss\n1,two\n").find("line 2: \"two\""), std::string::npos);
  EXPECT_NE(refusal("epoch,loss\n1,\n").find("line 2"), std::string::npos);
}

TEST_F(Training, IsCopiedAndDrawnWithAllItsSeeds) {
  log("one.log",
      "epoch,loss,adversarial,validation_error,learning_rate,seconds\n"
      "1,0.5,-0.2,0.9,1e-3,3\n2,0.3,0.1,0.8,1e-3,3\n");
  log("two.log",
      "epoch,loss,adversarial,validation_error,learning_rate,seconds\n"
      "1,0.6,0.2,0.9,1e-3,3\n");
  const fs::path folder = results() / "training";
  write_training_results("net",
                         {{"net.seed1", "seed 1", results() / "one.log",
                           nlohmann::json::parse(R"({"training": {"best_epoch": 2}})")},
                          {"net.seed2", "seed 2", results() / "two.log", {}},
                          {"net.seed3", "seed 3", results() / "absent.log", {}}},
                         folder);
  EXPECT_EQ(read("training/net.seed1.csv"), read("one.log"));
  EXPECT_FALSE(fs::exists(folder / "net.seed3.csv"));
  const std::string text = svg("training/net");
  for (const char* word : {">loss<", ">adversarial, absolute<", ">validation error<",
                           ">epoch kept<", "seed 1, seed 2", ">epoch<"}) {
    EXPECT_NE(text.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(text.find("learning"), std::string::npos);
}

TEST_F(Training, SharesHaveAPanelOfTheirOwn) {
  log("gan.log",
      "epoch,loss,discriminator,discriminator_right_truths,discriminator_right_images,"
      "validation_error\n"
      "1,0.5,1.4,0,0.75,0.9\n2,0.3,1.3,0.5,1,0.8\n");
  write_training_results("gan", {{"gan", "", results() / "gan.log", {}}}, results() / "training");
  const std::string text = svg("training/gan");
  for (const char* word : {">judged right<", ">discriminator<", ">discriminator right truths<"}) {
    EXPECT_EQ(count(text, word), 1u) << word;
  }
}

TEST_F(Training, NothingIsWrittenForASolverWithoutALog) {
  write_training_results("tsvd", {{"tsvd", "", results() / "absent.log", {}}},
                         results() / "training");
  EXPECT_FALSE(fs::exists(results() / "training"));
}

TEST_F(Training, ALogOfNoEpochsOrOnlyInfinitiesIsDrawn) {
  log("none.log", "epoch,loss,validation_error\n");
  log("inf.log", "epoch,loss,validation_error\n1,inf,nan\n");
  for (const char* name : {"none", "inf"}) {
    write_training_results(name, {{name, "", results() / (std::string(name) + ".log"), {}}},
                           results() / "training");
    EXPECT_NE(svg(std::string("training/") + name).find("no loss"), std::string::npos);
  }
}

}  // namespace
}  // namespace ertbench
