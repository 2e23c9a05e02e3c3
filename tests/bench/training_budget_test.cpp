// What a longer training buys: the points of the chart, and its picture.

#include "bench/training/training_budget.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

using nlohmann::json;
using testing::count;

ResultRow made_row(const std::string& family, int epochs, double fit_s, double error,
                   int best_epoch) {
  ResultRow row;
  row.label = family + " epochs=" + std::to_string(epochs);
  row.family = family;
  row.dataset = "test";
  row.metrics[Metric::relative_error] = {error, Interval{error - 0.01, error + 0.01}, error, 100,
                                         0};
  row.fit_s = fit_s;
  row.parameters =
      json{{"epochs", epochs},
           {"training", {{"best_epoch", best_epoch}, {"epochs", epochs}, {"scenes", 6000}}}};
  return row;
}

struct Budgets {
  std::vector<ResultRow> rows = {made_row("net", 10, 20, 0.5, 8), made_row("net", 1, 2, 0.8, 1),
                                 made_row("deep", 1, 9, 0.7, 1), made_row("deep", 10, 90, 0.4, 10)};
  BudgetQuestion question;

  Budgets() {
    question.dataset = "test";
    ResultRow failed = made_row("deep", 100, 900, 0.3, 90);
    failed.status = "timed out";
    rows.push_back(failed);
    ResultRow linear;
    linear.label = linear.family = "gn";
    linear.dataset = "test";
    linear.fit_s = 0.1;
    rows.push_back(linear);
    for (const ResultRow& row : rows) question.labels.push_back(row.label);
    question.labels.push_back("absent");
    ResultRow nothing;
    nothing.label = "no-contact";
    nothing.dataset = "test";
    nothing.metrics[Metric::relative_error].mean = 1;
    rows.push_back(nothing);
  }
};

TEST(TrainingBudget, AFamilyIsALineFromTheCheapestToTheDearest) {
  const Budgets made;
  const TrainingBudgets budgets = training_budgets_of(made.question, made.rows);
  ASSERT_EQ(budgets.lines.size(), 2u);
  EXPECT_EQ(budgets.lines[0].family, "net");
  ASSERT_EQ(budgets.lines[0].points.size(), 2u);
  EXPECT_EQ(budgets.lines[0].points[0].cost, 2);
  EXPECT_EQ(budgets.lines[0].points[1].error, 0.5);
  EXPECT_EQ(budgets.nothing, 1);
}

TEST(TrainingBudget, SaysWhoseBestEpochWasTheLast) {
  const Budgets made;
  const TrainingBudgets budgets = training_budgets_of(made.question, made.rows);
  EXPECT_FALSE(budgets.lines[0].points[0].converged);
  EXPECT_TRUE(budgets.lines[0].points[1].converged);
  EXPECT_FALSE(budgets.lines[1].points[1].converged);
}

TEST(TrainingBudget, ALineIsFlatWhereTheLastDoublingChangedLessThanOnePercent) {
  const auto line = [](double before, double after) {
    return BudgetLine{"net", {{"few", 100, before, {}}, {"many", 400, after, {}}}};
  };
  EXPECT_NEAR(*line(0.8, 0.2).last_doubling(), -0.5, 1e-12);  // two doublings
  EXPECT_FALSE(line(0.8, 0.2).flat());
  EXPECT_TRUE(line(0.5, 0.495).flat());
  EXPECT_FALSE(line(0.5, 0.48).flat());
  EXPECT_FALSE(line(0.48, 0.5).flat()) << "it grew";
  EXPECT_FALSE((BudgetLine{"net", {{"one", 100, 0.5, {}}}}.flat()));
}

TEST(TrainingBudget, WhatHasNoPointIsNamedWithItsReason) {
  const Budgets made;
  using Missing = std::vector<std::pair<std::string, std::string>>;
  EXPECT_EQ(
      training_budgets_of(made.question, made.rows).without,
      (Missing{{"deep epochs=100", "timed out"}, {"gn", "not trained"}, {"absent", "not run"}}));
}

TEST(TrainingBudget, ScenesAreCountedAsOftenAsTheyWereSeen) {
  Budgets made;
  made.question.cost = TrainingCost::scenes;
  EXPECT_EQ(training_budgets_of(made.question, made.rows).lines[0].points[1].cost, 60000);
  // Of two seeds, one of which ended early.
  made.rows[0].seeds.emplace().parameters =
      json::array({{{"training", made.rows[0].parameters->at("training")}},
                   {{"training", {{"best_epoch", 5}, {"epochs", 6}, {"scenes", 6000}}}}});
  EXPECT_EQ(training_budgets_of(made.question, made.rows).lines[0].points[1].cost, 48000);
}

TEST(TrainingBudget, TheBandReachesFromTheLeastToTheLargestTraining) {
  Budgets made;
  made.rows[0].seeds.emplace().means[Metric::relative_error] = {0.47, {}, 0.53};
  const TrainingBudgets budgets = training_budgets_of(made.question, made.rows);
  const BudgetPoint& three = budgets.lines[0].points[1];
  EXPECT_EQ(three.trainings.low, 0.47);
  EXPECT_EQ(three.trainings.high, 0.53);
  const BudgetPoint& one = budgets.lines[0].points[0];
  EXPECT_EQ(one.trainings.low, one.error);
  EXPECT_EQ(one.trainings.high, one.error);
}

class TrainingBudgetFigure : public testing::FigureTest {
 protected:
  std::string drawn(const TrainingBudgets& budgets) const {
    draw_training_budgets(budgets, "Budgets", results() / "budgets");
    EXPECT_TRUE(std::filesystem::exists(results() / "budgets.png"));
    return read("budgets.svg");
  }
};

TEST_F(TrainingBudgetFigure, NamesEveryLineAndWhatHasNone) {
  const Budgets made;
  const std::string svg = drawn(training_budgets_of(made.question, made.rows));
  for (const char* text : {">net<", ">deep<", ">net, -13 %<", ">deep, -16 %<"}) {
    EXPECT_EQ(count(svg, text), 1u) << text;  // in the key and at its end
  }
  for (const char* text : {"deep epochs=100: timed out", ">an empty image<",
                           ">time of the training, s<", ">hollow: had not converged"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }
  EXPECT_EQ(count(svg, "<title>net epochs=10\ntime of the training, s: 20.0\n"), 1u);
  EXPECT_EQ(count(testing::tooltips(svg), "had not converged"), 3u);
}

TEST_F(TrainingBudgetFigure, IsDrawnWithoutAResultAndWithASinglePoint) {
  Budgets made;
  EXPECT_NE(drawn(training_budgets_of(made.question, {})).find("no training has a result"),
            std::string::npos);
  made.question.labels = {"net epochs=10"};
  made.rows[0].metrics[Metric::relative_error].ci95.reset();
  EXPECT_EQ(count(drawn(training_budgets_of(made.question, made.rows)), ">net<"), 2u);
}

}  // namespace
}  // namespace ertbench
