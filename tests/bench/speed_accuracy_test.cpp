#include "bench/speed/speed_accuracy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/plot/palette.h"
#include "bench/plot/panel.h"
#include "bench/speed/speed_chart.h"
#include "bench/table/table.h"
#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

using nlohmann::json;
using testing::count;

ResultRow charted_row(const std::string& label, double p50, double error, double validation = 0) {
  ResultRow row;
  row.label = label;
  row.type = row.family = label.substr(0, label.find(' '));
  row.dataset = "test";
  row.frames = 1000;
  row.metrics[Metric::relative_error] = {error, Interval{error - 0.01, error + 0.01}, error, 1000,
                                         0,     Interval{error - 0.02, error + 0.02}};
  if (validation > 0) {
    row.validation.emplace()[Metric::relative_error] = {validation, {}, validation, 100, 0};
  }
  row.latency_us = LatencySummary{p50, 1.5 * p50, 3 * p50, {0.9 * p50, 1.1 * p50}};
  row.frames_per_s = 1e6 / p50;
  row.throughput_batch = 256;
  row.fit_s = 1;
  row.peak_rss_mb = 20;
  return row;
}

struct Sample {
  std::vector<ResultRow> rows;
  SpeedQuestion question;

  Sample() {
    rows = {charted_row("no-contact", 1, 1),     charted_row("gn", 4, 0.7, 0.72),
            charted_row("svd 10", 1, 0.9, 0.93), charted_row("svd 20", 2, 0.81, 0.8),
            charted_row("svd 40", 3, 0.8, 0.79), charted_row("net small", 100, 0.5, 0.51),
            charted_row("net", 600, 0.4, 0.42),  charted_row("net wide", 700, 0.41, 0.41),
            charted_row("tv few", 1200, 0.3),    charted_row("tv", 2000, 0.65),
            charted_row("broken", 0.5, 0.1)};
    rows.front().latency_us.reset();
    rows[8].frames_not_converged = 11;  // more than 1 %
    rows[9].frames_not_converged = 10;
    rows[10].status = "diverged";
    question.dataset = "test";
    for (const ResultRow& row : rows) question.labels.push_back(row.label);
    question.labels.erase(question.labels.begin());
    question.labels.push_back("never run");
    question.metric = Metric::relative_error;
    question.budgets_us = {0.1, 5, 1000};
    question.break_even_against = {"gn"};
    question.right_sizing = RightSizing{0.05, Metric::relative_error};
  }

  SpeedAccuracy chart() const { return speed_accuracy_of(question, rows); }
};

std::vector<std::string> frontier(const SpeedAccuracy& chart) {
  return to_json(chart).at("frontier").get<std::vector<std::string>>();
}

TEST(SpeedAccuracy, TheFrontierHoldsWhatNothingFasterBeats) {
  EXPECT_EQ(frontier(Sample().chart()),
            (std::vector<std::string>{"gn", "svd 10", "svd 20", "svd 40", "net small", "net"}));
}

TEST(SpeedAccuracy, AThousandthIsNoGain) {
  Sample sample;
  sample.rows.push_back(charted_row("gn exact", 5, 0.7 * (1 - 5e-4)));
  sample.question.labels.push_back("gn exact");
  sample.question.budgets_us = {8};
  const SpeedAccuracy chart = sample.chart();
  for (const SpeedPoint& point : chart.points) {
    EXPECT_FALSE(point.frontier && point.label == "gn exact");
  }
  EXPECT_EQ(to_json(chart).at("within_budget")[0].at("label"), "gn");
}

/// However good its numbers, and whichever way it failed.
TEST(SpeedAccuracy, WhatFailedOrDidNotConvergeIsShownAndNeverChosen) {
  const Sample sample;
  const SpeedAccuracy chart = sample.chart();
  ASSERT_EQ(chart.points.size(), sample.question.labels.size());
  const auto point = [&](const std::string& label) {
    return *std::find_if(chart.points.begin(), chart.points.end(),
                         [&](const SpeedPoint& p) { return p.label == label; });
  };
  EXPECT_EQ(point("broken").standing, Standing::failed);
  EXPECT_EQ(point("broken").remark, "diverged");
  EXPECT_EQ(point("tv few").standing, Standing::not_converged);
  EXPECT_EQ(point("tv few").remark, "not converged in 1.1 % of the frames");
  EXPECT_EQ(point("tv").standing, Standing::ok);
  EXPECT_EQ(point("never run").remark, "not run");
  const json out = to_json(chart);
  for (const char* label : {"broken", "tv few", "never run"}) {
    EXPECT_EQ(out.at("frontier").dump().find(label), std::string::npos);
    EXPECT_EQ(out.at("within_margin").dump().find(label), std::string::npos);
    EXPECT_EQ(out.at("within_budget").dump().find(label), std::string::npos);
    EXPECT_NE(markdown_of(speed_table(chart, "")).find(label), std::string::npos);
  }
}

TEST(SpeedAccuracy, ChoosesByMarginAndByBudget) {
  const json out = to_json(Sample().chart());
  const auto label = [&](const char* list, int i) { return out.at(list)[i].at("label"); };
  EXPECT_EQ(label("within_margin", 0), "net");       // 0.400
  EXPECT_EQ(label("within_margin", 2), "net");       // 0.5 is above 0.48
  EXPECT_TRUE(label("within_budget", 0).is_null());  // nothing that fast
  EXPECT_EQ(label("within_budget", 1), "svd 40");    // gn's p99 is 6
  EXPECT_EQ(label("within_budget", 2), "net");       // p99 900

  const std::string csv = csv_of(speed_choices(Sample().chart()));
  EXPECT_EQ(csv.substr(0, csv.find('\n')),
            "choice,margin,budget_us,label,error,error_low,error_high,p50_us,p99_us");
  EXPECT_NE(csv.find("within 20 % of the least error,0.2,,net,0.4,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\nthe least error with p99 within 5.00 µs,,5,svd 40,"), std::string::npos)
      << csv;
}

TEST(SpeedAccuracy, BudgetsToContactsAreThoseOfTheContacts) {
  Sample sample;
  for (ResultRow& row : sample.rows) {
    if (!row.latency_us || row.label == "net") continue;  // net was not timed to the contacts
    row.latency_us->contacts_p50 = row.latency_us->p50 + 30;
    row.latency_us->contacts_p99 = row.latency_us->p99 + 46;
  }
  const SpeedAccuracy chart = sample.chart();
  const json within = to_json(chart).at("within_budget");
  ASSERT_EQ(within.size(), 3 + 5U);
  std::vector<json> labels;
  for (std::size_t i = 3; i < within.size(); ++i) {
    EXPECT_EQ(within[i].at("to_contacts"), true);
    labels.push_back(within[i].at("label"));
  }
  // 50, 100, 200, 500 and 1000 us: svd 10 takes 47.5, svd 20 49, svd 40 50.5, gn 52, net small 196.
  EXPECT_EQ(labels, (std::vector<json>{"svd 20", "gn", "net small", "net small", "net small"}));
  const std::string csv = csv_of(speed_choices(chart));
  EXPECT_NE(csv.find("the least error with p99 to contacts within 50.0 µs,,,svd 20,"),
            std::string::npos)
      << csv;
  EXPECT_NE(csv.find(",50,32,49\n"), std::string::npos) << csv;
}

/// A configuration that is the best on the validation set is recommended, with what it has on the
/// test set, where it need not be the best.
TEST(SpeedAccuracy, RecommendationsAreChosenOnTheValidationSet) {
  Sample sample;
  EXPECT_EQ(to_json(sample.chart()).at("chosen_on"), "test");
  for (ResultRow& row : sample.rows) {
    row.validation.emplace();
    const auto& error = row.metrics[Metric::relative_error].mean;
    (*row.validation)[Metric::relative_error].mean = row.label == "gn" ? std::optional(0.1) : error;
  }
  const json out = to_json(sample.chart());
  EXPECT_EQ(out.at("chosen_on"), "validation");
  EXPECT_EQ(out.at("within_budget")[2].at("label"), "gn");
  EXPECT_EQ(out.at("within_margin")[0].at("label"), "gn");
}

TEST(SpeedAccuracy, RightSizesAreTheSmallestWithinTheMarginOnTheValidationSet) {
  const SpeedAccuracy chart = Sample().chart();
  const json expected = json::parse(R"([{"family": "svd", "best": "svd 40", "chosen": "svd 20"},
                                        {"family": "net", "best": "net wide", "chosen": "net"}])");
  EXPECT_EQ(to_json(chart).at("right_sizes"), expected);
}

TEST(SpeedAccuracy, BreakEvenIsWhereTheFasterFramesHaveMadeGoodTheFit) {
  Sample sample;
  sample.rows[2].fit_s = 4;  // svd 10: 3 s more, 3 µs a frame less
  const json frames = to_json(sample.chart()).at("break_even_frames").at("gn");
  EXPECT_EQ(frames.at("svd 10"), 1e6);
  EXPECT_EQ(frames.at("svd 20"), 0);        // no longer to fit, and faster
  EXPECT_TRUE(frames.at("net").is_null());  // slower: never
  EXPECT_TRUE(frames.at("gn").is_null());
  // In the table what is slower is told apart from what is not known.
  const auto cell_of_net = [&] {
    const Table table = speed_table(sample.chart(), "");
    for (const auto& row : table.sections.back().rows) {
      if (row.front().text == "net") return row.rbegin()[1].text;  // before the remarks
    }
    return std::string("no row");
  };
  EXPECT_EQ(cell_of_net(), "never");
  for (ResultRow& row : sample.rows) {
    if (row.label == "gn") row.fit_s.reset();
  }
  EXPECT_EQ(cell_of_net(), "—");
}

TEST(SpeedAccuracy, TheStaircaseGoesDownAndOutToTheFarSide) {
  const SpeedAccuracy chart = Sample().chart();
  const SpeedPanel panel = speed_panel(chart, {0, 0, 600, 400}, false);
  const auto steps = staircase(chart, panel);
  ASSERT_EQ(steps.size(), 13u);
  EXPECT_EQ(steps.front(), std::pair(1.0, panel.errors.high));
  EXPECT_EQ(steps.back(), std::pair(panel.axis.high, 0.4));
  for (std::size_t i = 1; i < steps.size(); ++i) {
    EXPECT_GE(steps[i].first, steps[i - 1].first);
    EXPECT_LE(steps[i].second, steps[i - 1].second);
  }
}

TEST(SpeedAccuracy, AnErrorBeyondDoingNothingDoesNotStretchTheScale) {
  Sample sample;
  sample.rows.push_back(charted_row("svd 104", 4.5, 9752));
  sample.question.labels.push_back("svd 104");
  const SpeedPanel panel = speed_panel(sample.chart(), {0, 0, 600, 400}, false);
  EXPECT_LT(panel.errors.high, 1.2);
  EXPECT_FALSE(panel.holds(9752));
}

TEST(LabelLayout, LabelsMeetNeitherEachOtherNorWhatIsTaken) {
  std::vector<PointLabel> labels;
  std::vector<Box> taken;
  for (int i = 0; i < 12; ++i) {
    labels.push_back({"configuration " + std::to_string(i), 200 + 4.0 * i, 150 + 3.0 * (i % 5)});
    taken.push_back(
        {labels.back().x - 5, labels.back().y - 5, labels.back().x + 5, labels.back().y + 5});
  }
  const Box area{0, 0, 500, 320};
  const auto places = place_labels(labels, 10, area, taken);
  int placed = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!places[i]) continue;
    ++placed;
    const Box& box = places[i]->box;
    EXPECT_GE(box.left, area.left);
    EXPECT_LE(box.bottom, area.bottom);
    for (const Box& other : taken) EXPECT_FALSE(box.overlaps(other));
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_FALSE(places[j] && box.overlaps(places[j]->box)) << i << " " << j;
    }
  }
  EXPECT_GE(placed, 10);
}

TEST(LabelLayout, LinesToPointsCrossNeitherEachOtherNorLabels) {
  std::vector<PointLabel> labels;
  std::vector<Box> taken;
  // So many that no place is right for all that come after: 25 crossings, if none gives way.
  for (int i = 0; i < 22; ++i) {
    labels.push_back({"configuration " + std::to_string(i), 200 + 9.0 * (i % 5), 150 + 5.0 * i});
    taken.push_back(Box::around(labels.back().x, labels.back().y, 5));
  }
  const auto places = place_labels(labels, 10, {0, 0, 500, 400}, taken);
  int leaders = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!places[i] || !places[i]->leader) continue;
    ++leaders;
    const Segment leader = leader_of(labels[i], places[i]->box);
    for (std::size_t j = 0; j < labels.size(); ++j) {
      if (j == i || !places[j]) continue;
      EXPECT_FALSE(leader.crosses(places[j]->box)) << i << " through the name of " << j;
      EXPECT_FALSE(places[j]->leader && leader.crosses(leader_of(labels[j], places[j]->box)))
          << i << " " << j;
    }
  }
  EXPECT_GE(leaders, 10);
}

/// A name stands beside a line through its first place where there is room, and on it where not.
TEST(LabelLayout, LinesRunThroughNamesWhereThereIsNoOtherRoomAlone) {
  const std::vector<PointLabel> labels{{"name", 100, 100}};
  const Segment line{108, 100, 250, 100};
  EXPECT_TRUE(line.crosses(place_labels(labels, 10, {0, 0, 300, 300}, {})[0]->box));
  EXPECT_FALSE(line.crosses(place_labels(labels, 10, {0, 0, 300, 300}, {}, {line})[0]->box));
  const auto narrow = place_labels(labels, 10, {95, 90, 300, 110}, {}, {line});
  ASSERT_TRUE(narrow[0]);
  EXPECT_TRUE(line.crosses(narrow[0]->box));
}

/// Of two places the one whose line runs through less, even if it is farther off.
TEST(LabelLayout, LinesToPointsRunThroughLittleOfWhatIsTaken) {
  const std::vector<PointLabel> labels{{"name", 100, 100}};
  // There is room on both sides; on the left behind a mark, then on the right, nearer, behind two.
  std::vector<Box> taken{{0, 0, 300, 90}, {0, 110, 300, 200}, Box::around(82, 100, 3)};
  const auto place_of = [&] { return place_labels(labels, 10, {0, 0, 300, 200}, taken)[0]->box; };
  EXPECT_GT(place_of().left, 100);
  for (const double x : {107.0, 113.0}) taken.push_back(Box::around(x, 100, 3));
  EXPECT_LT(place_of().right, 79);
}

/// Where the first one takes what is best for it alone, none is left for the last.
TEST(LabelLayout, LabelsGiveWayToOneForWhichThereIsNoRoomOtherwise) {
  const double width = text_width("a name", 10) + 4;
  const std::vector<PointLabel> labels{
      {"a name", 67, 100}, {"a name", 70, 100}, {"a name", 73, 100}};
  const Box strip{70 - 1.5 * width - 10, 105, 70 + 1.5 * width + 10, 121};
  const auto places = place_labels(labels, 10, strip, {});
  const auto again = place_labels(labels, 10, strip, {});
  for (std::size_t i = 0; i < labels.size(); ++i) {
    ASSERT_TRUE(places[i]) << i;
    EXPECT_EQ(places[i]->box.left, again[i]->box.left) << i;
  }
}

TEST(LabelLayout, SegmentsCross) {
  const Segment rising{0, 0, 10, 10};
  EXPECT_TRUE(rising.crosses(Segment{0, 10, 10, 0}));
  EXPECT_FALSE(rising.crosses(Segment{0, 10, 4, 6}));  // would, if it went on
  EXPECT_TRUE(rising.crosses(Box{4, 0, 6, 20}));
  EXPECT_TRUE(rising.crosses(Box{-1, -1, 20, 20}));  // lies within
  EXPECT_FALSE(rising.crosses(Box{6, 0, 9, 4}));
}

/// What lies beyond the scale is at one height: names of many would stand in a pile.
TEST(SpeedPanelLabels, AFamilyOfWhichMuchLiesBeyondTheScaleHasOneName) {
  Sample sample;
  for (const int rank : {60, 80, 100}) {
    sample.rows.push_back(charted_row("svd " + std::to_string(rank), 0.1 * rank, 0.05 * rank));
    sample.question.labels.push_back(sample.rows.back().label);
  }
  const SpeedAccuracy chart = sample.chart();
  const SpeedPanel panel = speed_panel(chart, {0, 0, 400, 300}, false);
  const auto labels = labels_of(chart, panel, [](const SpeedPoint& point) {
    return point.family == "svd" ? hue(1) : ink::black;
  });
  const auto found = std::find_if(labels.begin(), labels.end(), [](const PointLabel& label) {
    return label.text == "svd, 3 settings: 3.00 to 5.00";
  });
  ASSERT_NE(found, labels.end());
  EXPECT_EQ(found->x, panel.x_of(10));
  EXPECT_EQ(found->colour.hex(), hue(1).hex());
  for (const PointLabel& label : labels) EXPECT_NE(label.text.substr(0, 7), "svd 100");
}

class SpeedChart : public testing::FigureTest {};

TEST_F(SpeedChart, EveryConfigurationIsThereWithItsValues) {
  const SpeedAccuracy chart = Sample().chart();
  draw_speed_figure(chart, "Speed & accuracy", results() / "speed");
  const std::string svg = read("speed.svg");
  EXPECT_EQ(read("speed.png").substr(0, 8), "\x89PNG\r\n\x1a\n");
  for (const SpeedPoint& point : chart.points) {
    EXPECT_NE(svg.find(point.label), std::string::npos) << point.label;
  }
  EXPECT_NE(svg.find("lower left is better"), std::string::npos);
  EXPECT_NE(svg.find("p50 600 µs, p99 900 µs"), std::string::npos) << "values on hover";
  EXPECT_NE(svg.find("never run: not run"), std::string::npos);
}

/// The front page names what nothing faster beats, and the best of each method; a setting between
/// is drawn without a name.
TEST_F(SpeedChart, TheFrontPageNamesTheFrontierAndTheBestOfEachMethod) {
  SpeedQuestion question;
  question.dataset = "test";
  std::vector<ResultRow> rows;
  const auto add = [&](const std::string& label, const std::string& type, double us, double error) {
    rows.push_back(charted_row(label, us, error));
    rows.back().type = type;
    rows.back().metrics[question.metric].mean = error;
    rows.back().parameters = JsonValue(nlohmann::json{{"prior", "noser"}});
    question.labels.push_back(label);
  };
  add("gauss", "one-step-gn", 5, 0.7);
  add("fcnn widths=144-36-36", "fcnn", 40, 0.6);
  add("fcnn widths=288-72-72", "fcnn", 60, 0.5);
  add("lean-net width=8", "lean-net", 30, 0.4);
  add("pdipm", "pdipm", 20, 0.3);
  draw_frontier_figure(speed_accuracy_of(question, rows), rows, results() / "frontier");
  const std::string svg = read("frontier.svg");
  for (const char* name : {"GN (NOSER)", "fcnn 288", "lean-net 8"}) {
    EXPECT_NE(svg.find(name), std::string::npos) << name;
  }
  for (const char* name : {"fcnn 144", "pdipm"})
    EXPECT_EQ(svg.find(name), std::string::npos) << name;
}

TEST_F(SpeedChart, NothingMeasuredIsStillAChart) {
  SpeedQuestion question = Sample().question;
  draw_speed_figure(speed_accuracy_of(question, {}), "Empty", results() / "speed");
  EXPECT_NE(read("speed.svg").find("net wide: not run"), std::string::npos);
}

}  // namespace
}  // namespace ertbench
