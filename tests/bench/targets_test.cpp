// How many touch: scores of found contacts by hand, the isotonic fit, gaps that are told apart.

#include "bench/studies/targets.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/report/report.h"
#include "bench/table/table.h"
#include "core/statistics.h"
#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;
using testing::FigureTest;

const ContactDistances kDistances{20, 50};

TargetFrame frame_of(std::size_t scene, std::vector<Vector2d> places) {
  TargetFrame frame;
  frame.scene = scene;
  frame.radii_mm.assign(places.size(), 12);
  frame.places_mm = std::move(places);
  return frame;
}

FrameReading reading_of(const std::vector<Vector2d>& places) {
  FrameReading reading;
  for (const Vector2d& place : places) reading.contacts.push_back({place, 1, 0.01, 300});
  return reading;
}

ContactScore score(int there, int found, int matched) {
  return {there, found, matched, 4.0 * matched, 10};
}

TEST(Targets, TruthsAreInMillimetresAndOfTheSheetAlone) {
  const Sensor sensor;  // a unit is 100 mm
  Contact disc;
  disc.centre = {0.5, 0};
  disc.half_size = {0.12, 0.12};
  Contact outside = disc;
  outside.centre = {1.5, 0};
  Contact triangle;
  triangle.shape = Shape::polygon;
  triangle.vertices = {{-0.3, 0}, {0, 0}, {0, 0.3}};  // centroid (-.1, .1)
  const TargetFrame frame = target_frame(sensor, {{disc, outside, triangle}, {}}, 3);
  EXPECT_EQ(frame.scene, 3);
  ASSERT_EQ(frame.contacts(), 2);
  EXPECT_NEAR((frame.places_mm[0] - Vector2d(50, 0)).norm(), 0, 1e-9);
  EXPECT_NEAR(frame.radii_mm[0], 12, 1e-9);
  EXPECT_NEAR((frame.places_mm[1] - Vector2d(-10, 10)).norm(), 0, 1e-9);
  EXPECT_NEAR(frame.radii_mm[1], std::hypot(20, 10), 1e-9);
  EXPECT_NEAR(frame.gap_mm().value(), std::hypot(60, 10) - 12 - std::hypot(20, 10), 1e-6);
}

TEST(Targets, ThereIsAGapBetweenTwo) {
  EXPECT_EQ(frame_of(0, {{0, 0}, {30, 40}}).gap_mm(), 26);
  EXPECT_EQ(frame_of(0, {{0, 0}, {20, 0}}).gap_mm(), -4);
  EXPECT_EQ(frame_of(0, {{0, 0}}).gap_mm(), std::nullopt);
  EXPECT_EQ(frame_of(0, {{0, 0}, {30, 0}, {60, 0}}).gap_mm(), std::nullopt);
}

TEST(Targets, AFrameByHand) {
  // (0, 0) is found 5 mm away, (60, 0) not at all: what is nearest is 25 mm off, a ghost.
  const TargetFrame truth = frame_of(0, {{0, 0}, {60, 0}});
  const ContactScore score =
      match_targets(truth, reading_of({{60, 25}, {3, 4}, {-80, 0}}).contacts, kDistances);
  EXPECT_EQ(score.true_count, 2);
  EXPECT_EQ(score.found, 3);
  EXPECT_EQ(score.matched, 1);
  EXPECT_DOUBLE_EQ(score.distance_mm, 5);
  EXPECT_DOUBLE_EQ(score.ospa_mm, (5.0 + 25 + 50) / 3);
}

TEST(Targets, NumbersOfAllFramesTogether) {
  const std::vector<TargetFrame> frames = {frame_of(0, {{0, 0}, {60, 0}}),
                                           frame_of(1, {{0, 0}, {60, 0}}), frame_of(2, {{0, 0}})};
  const std::vector<std::optional<ContactScore>> scores = {score(2, 3, 1), score(2, 2, 2),
                                                           score(1, 0, 0)};
  const auto counts = count_targets(frames, scores);
  ASSERT_EQ(counts.size(), 2);
  const TargetCount& two = counts.at(2);
  EXPECT_EQ(two.frames, 2);
  EXPECT_EQ(two.scenes, 2);
  const auto value = [&](const char* key) { return two.metrics.at(key)->value; };
  EXPECT_DOUBLE_EQ(value("precision"), 3.0 / 5);
  EXPECT_DOUBLE_EQ(value("recall"), 3.0 / 4);
  EXPECT_DOUBLE_EQ(value("f1"), 2.0 * 3 / (5 + 4));
  EXPECT_DOUBLE_EQ(value("ghosts"), 1);
  EXPECT_DOUBLE_EQ(value("right_number"), 0.5);
  EXPECT_DOUBLE_EQ(value("location_error_mm"), 4);
  EXPECT_DOUBLE_EQ(value("ospa_mm"), 10);
  // Of two scenes the resamples are either of them twice, or both.
  EXPECT_EQ(two.metrics.at("recall")->ci95, (Interval{0.5, 1}));
  EXPECT_EQ(two.metrics.at("right_number")->ci95, wilson_interval(1, 2));

  // Where nothing was found there is no precision and no error, but a recall.
  const TargetCount& one = counts.at(1);
  EXPECT_EQ(one.metrics.at("precision"), std::nullopt);
  EXPECT_EQ(one.metrics.at("location_error_mm"), std::nullopt);
  EXPECT_EQ(one.metrics.at("recall")->value, 0);
  EXPECT_EQ(one.metrics.at("f1")->value, 0);
}

TEST(Targets, DrawsOfASceneStayTogether) {
  // A scene that is found in all its draws and one that never is: were the frames independent, the
  // interval would be a narrow one around a half.
  std::vector<TargetFrame> frames;
  std::vector<std::optional<ContactScore>> scores;
  for (int draw = 0; draw < 100; ++draw) {
    for (const std::size_t scene : {0, 1}) {
      frames.push_back(frame_of(scene, {{0, 0}}));
      scores.emplace_back(scene == 0 ? score(1, 1, 1) : score(1, 0, 0));
    }
  }
  const TargetCount one = count_targets(frames, scores).at(1);
  EXPECT_EQ(one.scenes, 2);
  EXPECT_EQ(one.frames, 200);
  for (const char* key : {"recall", "right_number"}) {
    EXPECT_DOUBLE_EQ(one.metrics.at(key)->value, 0.5);
    EXPECT_EQ(one.metrics.at(key)->ci95, (Interval{0, 1})) << key;
  }
}

TEST(Targets, FramesWithoutAScoreDoNotCount) {
  const std::vector<TargetFrame> frames = {frame_of(0, {{0, 0}}), frame_of(1, {{0, 0}})};
  const std::vector<std::optional<ContactScore>> scores = {score(1, 1, 1), std::nullopt};
  EXPECT_EQ(count_targets(frames, scores).at(1).frames, 1);
}

TEST(Targets, SetsOfPairsAloneServeTheGaps) {
  const auto counting = [](std::vector<std::vector<Vector2d>> truths,
                           std::vector<std::size_t> sets) {
    std::vector<TargetFrame> frames;
    for (auto& places : truths) frames.push_back(frame_of(frames.size(), std::move(places)));
    leave_out_pair_sets(frames, sets);
    std::vector<bool> out;
    for (const TargetFrame& frame : frames) out.push_back(frame.counts);
    return out;
  };
  const std::vector<Vector2d> one = {{0, 0}};
  const std::vector<Vector2d> two = {{0, 0}, {60, 0}};
  EXPECT_EQ(counting({one, two, two}, {0, 0, 1}), (std::vector<bool>{true, true, false}));
  EXPECT_EQ(counting({one, two}, {0, 1}), (std::vector<bool>{true, true}));  // no pairs elsewhere
  EXPECT_EQ(counting({two}, {0}), (std::vector<bool>{true}));
}

TEST(IsotonicFit, PoolsAdjacentViolators) {
  // 3 and 2 are out of order and become 2.5, which 1 is below: 3, 2, 1 have the mean 2.
  const std::vector<WeightedPoint> points = {{1, 1, 1}, {2, 3, 1}, {3, 2, 1},
                                             {4, 1, 1}, {5, 4, 1}, {6, 5, 0}};
  const auto fit = isotonic_fit(points);
  ASSERT_EQ(fit.size(), 3);
  EXPECT_EQ(fit[0].value, 1);
  EXPECT_DOUBLE_EQ(fit[1].value, 2);
  EXPECT_EQ(fit[1].first, 2);
  EXPECT_EQ(fit[1].last, 4);
  EXPECT_EQ(fit[1].weight, 3);
  EXPECT_EQ(fit[2].value, 4);
  EXPECT_EQ(fit[2].last, 5);  // the point without weight is not there
}

TEST(IsotonicFit, EqualPlacesAreOneAndWeightsCount) {
  const std::vector<WeightedPoint> points = {{1, 0, 1}, {1, 1, 3}, {2, 0, 1}, {3, 1, 2}};
  const auto fit = isotonic_fit(points);
  ASSERT_EQ(fit.size(), 2);
  EXPECT_DOUBLE_EQ(fit[0].value, 3.0 / 5);
  EXPECT_EQ(fit[0].last, 2);
  EXPECT_EQ(fit[1].value, 1);
  EXPECT_TRUE(isotonic_fit({}).empty());
}

/// `scenes` at each gap, of which so many were told apart.
std::vector<GapTrial> trials_of(const std::vector<std::pair<double, int>>& told_apart,
                                int scenes = 10) {
  std::vector<GapTrial> trials;
  for (const auto& [gap, count] : told_apart) {
    for (int i = 0; i < scenes; ++i) trials.push_back({gap, 1, i < count ? 1 : 0});
  }
  return trials;
}

TEST(TargetGaps, TheResolvableGapIsInterpolated) {
  const TargetGaps gaps = measure_gaps(trials_of({{0, 0}, {10, 6}, {20, 10}, {30, 10}}));
  EXPECT_EQ(gaps.resolvable.state, ResolvableGap::State::resolved);
  EXPECT_NEAR(gaps.resolvable.gap_mm.value(), 15, 1e-9);  // half way from 60 to 100 %
  ASSERT_TRUE(gaps.resolvable.low_mm && gaps.resolvable.high_mm);
  EXPECT_LT(*gaps.resolvable.low_mm, 15);
  EXPECT_GT(*gaps.resolvable.high_mm, 15);
  ASSERT_EQ(gaps.bins.size(), 4);
  EXPECT_DOUBLE_EQ(gaps.bins[1].told_apart.value, 0.6);
  EXPECT_EQ(gaps.bins[1].told_apart.ci95, wilson_interval(6, 10));
  EXPECT_EQ(gaps.bins[1].low_mm, 10);
  EXPECT_EQ(gaps.bins[1].scenes, 10);
}

TEST(TargetGaps, FourInFiveIsEnough) {
  const TargetGaps gaps = measure_gaps(trials_of({{0, 0}, {10, 8}, {20, 8}}));
  EXPECT_EQ(gaps.resolvable.state, ResolvableGap::State::resolved);
  EXPECT_NEAR(gaps.resolvable.gap_mm.value(), 10, 1e-6);
}

TEST(TargetGaps, WhatLeavesTheSetIsSaid) {
  const ResolvableGap never = measure_gaps(trials_of({{0, 0}, {10, 2}, {20, 5}})).resolvable;
  EXPECT_EQ(never.state, ResolvableGap::State::never);
  EXPECT_EQ(never.gap_mm, std::nullopt);
  EXPECT_EQ(never.high_mm, std::nullopt);
  EXPECT_EQ(never.text(), "not within the set");

  const ResolvableGap always = measure_gaps(trials_of({{2, 10}, {10, 10}, {20, 10}})).resolvable;
  EXPECT_EQ(always.state, ResolvableGap::State::always);
  EXPECT_EQ(always.low_mm, std::nullopt);
  EXPECT_EQ(always.text(), "≤ 2.0");
  EXPECT_EQ(always.interval(), "[< set, 2.0]");

  // The last scene alone was told apart: that may be chance.
  std::vector<GapTrial> trials = trials_of({{0, 0}, {10, 0}});
  trials.push_back({20, 1, 1});
  EXPECT_EQ(measure_gaps(trials).resolvable.state, ResolvableGap::State::never);

  EXPECT_EQ(measure_gaps(trials_of({{0, 0}, {10, 4}}, 4)).resolvable.state,
            ResolvableGap::State::too_few_pairs);
  EXPECT_EQ(measure_gaps({}).scenes, 0);
}

TEST(TargetGaps, AreOfScenesWithTwoContacts) {
  std::vector<TargetFrame> frames = {frame_of(7, {{0, 0}, {54, 0}}), frame_of(7, {{0, 0}, {54, 0}}),
                                     frame_of(8, {{0, 0}}), frame_of(9, {{0, 0}, {34, 0}})};
  for (TargetFrame& frame : frames) frame.counts = false;  // counts for nothing here
  const std::vector<std::optional<ContactScore>> scores = {score(2, 2, 2), score(2, 3, 1),
                                                           score(1, 1, 1), score(2, 4, 2)};
  const auto trials = gap_trials(frames, scores);
  ASSERT_EQ(trials.size(), 2);
  EXPECT_EQ(trials[0].gap_mm, 10);
  EXPECT_EQ(trials[0].share(), 1);
  EXPECT_EQ(trials[1].gap_mm, 30);
  EXPECT_EQ(trials[1].frames, 2);
  EXPECT_EQ(trials[1].share(), 0.5);
}

class TargetsReport : public FigureTest {
 protected:
  /// A solver that finds all, one that is 25 mm off with half of the second ones, one that crashed.
  TargetsReport() {
    std::size_t scene = 0;
    for (int gap = 0; gap < 60; gap += 2) {
      frames_.push_back(frame_of(scene++, {{-40, 0}, {gap - 16.0, 0}}));
      frames_.push_back(frame_of(scene++, {{gap - 30.0, 20}}));
    }
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      std::vector<Vector2d> places = frames_[f].places_mm;
      all_.push_back(reading_of(places));
      if (places.size() == 2 && f % 4 == 0) places[1].y() += 25;
      some_.push_back(reading_of(places));
    }
    readings_.resize(3);
    readings_[0].label = "all";
    readings_[1].label = "some";
    readings_[2] = {"none", "crashed: Aborted", {}};
    for (std::size_t f = 0; f < frames_.size(); ++f) {
      readings_[0].found.push_back(&all_[f]);
      readings_[1].found.push_back(&some_[f]);
      readings_[2].found.push_back(nullptr);
    }
    results_ = target_results(frames_, readings_, kDistances);
  }

  Study study() const { return study_of_targets(circumstances_, results_); }

  std::vector<TargetFrame> frames_;
  std::vector<FrameReading> all_, some_;
  std::vector<TargetReadings> readings_;
  TargetResults results_;
  TargetCircumstances circumstances_{"targets", "rising law, 50 dB absolute", kDistances};
};

TEST_F(TargetsReport, SummaryHasAllNumbers) {
  const json summary = study().numbers;
  EXPECT_EQ(summary["conditions"], "rising law, 50 dB absolute");
  EXPECT_EQ(summary["match_mm"], 20);
  const json& all = summary["solvers"]["all"];
  EXPECT_EQ(all["by_count"]["2"]["recall"]["mean"], 1);
  EXPECT_EQ(all["by_count"]["2"]["recall"]["ci95"], (json{1.0, 1.0}));
  EXPECT_EQ(all["by_count"]["1"]["scenes"], 30);
  EXPECT_EQ(all["resolvable_gap_mm"]["value"], 0);
  EXPECT_EQ(all["resolvable_gap_mm"]["state"], "at the least gap already");
  const json& some = summary["solvers"]["some"];
  EXPECT_EQ(some["by_count"]["2"]["recall"]["mean"], 0.75);
  EXPECT_EQ(some["by_count"]["2"]["ghosts"]["mean"], 0.5);
  EXPECT_EQ(some["resolvable_gap_mm"]["state"], "not within the set");
  EXPECT_EQ(some["resolvable_gap_mm"]["value"], nullptr);
  const json& none = summary["solvers"]["none"];
  EXPECT_EQ(none["failure"], "crashed: Aborted");
  EXPECT_TRUE(none["by_count"].empty());
}

TEST_F(TargetsReport, TablesKeepASolverThatFailed) {
  const TableSection counts = targets_count_table(circumstances_, results_);
  EXPECT_NO_THROW(counts.require_cells());
  ASSERT_EQ(counts.rows.size(), 6);  // three solvers with one contact, then with two
  EXPECT_EQ(counts.rows[4][0].text, "some");
  EXPECT_EQ(counts.rows[4][4].text, "0.750");
  EXPECT_EQ(counts.rows[5][0].lines, std::vector<std::string>{"crashed: Aborted"});
  EXPECT_EQ(counts.rows[5][4].text, "—");
  EXPECT_NE(counts.caption.find("rising law, 50 dB"), std::string::npos);
  const TableSection gaps = targets_gap_table(circumstances_, results_);
  EXPECT_NO_THROW(gaps.require_cells());
  ASSERT_EQ(gaps.rows.size(), 3);
  EXPECT_EQ(gaps.rows[0][2].text, "≤ 0.0");
  EXPECT_EQ(gaps.rows[2][2].text, "—");
  EXPECT_NE(csv_of(targets_gap_data(results_)).find("some,resolvable_gap_mm,0,58,,30,not within"),
            std::string::npos);
}

TEST_F(TargetsReport, FiguresAndFilesAreWritten) {
  const auto sections = study().report("Targets", results());
  ASSERT_EQ(sections.size(), 1);
  EXPECT_EQ(files(), (std::set<std::string>{"targets.csv", "targets.md", "targets.png",
                                            "targets.svg", "targets_gaps.csv"}));
  for (const ReportFigure& figure : sections[0].figures) EXPECT_TRUE(figure.drawn);
  EXPECT_NE(read("targets.svg").find("crashed: Aborted"), std::string::npos);
}

TEST_F(TargetsReport, WhereNoSolverGotThatFar) {
  const std::vector<TargetReadings> readings = {readings_[2]};
  results_ = target_results(frames_, readings, kDistances);
  const auto sections = study().report("Targets", results());
  EXPECT_EQ(sections[0].tables[0].rows.size(), 2);
  for (const ReportFigure& figure : sections[0].figures) EXPECT_TRUE(figure.drawn);
}

TEST_F(TargetsReport, AReadingForEachFrameIsAsked) {
  readings_[0].found.pop_back();
  EXPECT_THROW(target_results(frames_, readings_, kDistances), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
