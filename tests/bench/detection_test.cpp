#include <gtest/gtest.h>

#include <algorithm>

#include "bench/ladder/ladder_results.h"
#include "bench/table/table.h"

namespace ertbench {
namespace {

/// Frames of a level: as many as named that failed or did not, and were flagged as `status` says or
/// were not.
LadderLevel level_of(int detected, int missed, int false_alarms, int passed,
                     FrameStatus status = FrameStatus::suspect) {
  LadderLevel level{1, {}, ""};
  const auto add = [&](int count, FrameStatus said, int failed) {
    JudgedFrame frame;
    frame.status = said;
    frame.failed = failed;
    level.frames.insert(level.frames.end(), static_cast<std::size_t>(count), frame);
  };
  const int misplaced = static_cast<int>(FailureKind::misplaced);
  add(detected, status, misplaced);
  add(missed, FrameStatus::ok, misplaced);
  add(false_alarms, status, 0);
  add(passed, FrameStatus::ok, 0);
  return level;
}

TEST(Detection, CountsFramesByFailureAndDoubt) {
  const DetectionCounts counts = detection_at(level_of(3, 1, 2, 14));
  EXPECT_EQ(counts.failing, 4);
  EXPECT_EQ(counts.good, 16);
  EXPECT_DOUBLE_EQ(*counts.detection_rate(), 0.75);
  EXPECT_DOUBLE_EQ(*counts.false_alarm_rate(), 0.125);
  EXPECT_DOUBLE_EQ(*counts.suspect_rate(), 0.25);
  for (const FrameStatus status : {FrameStatus::not_converged, FrameStatus::undefined}) {
    const DetectionCounts other = detection_at(level_of(3, 1, 2, 14, status));
    EXPECT_EQ(other.detected, 3);
    EXPECT_EQ(other.false_alarms, 2);
    EXPECT_EQ(other.suspect, 0);
  }
}

TEST(Detection, RatesOfNoFramesAreNone) {
  EXPECT_FALSE(detection_at(level_of(0, 0, 1, 5)).detection_rate());
  EXPECT_FALSE(detection_at(level_of(1, 5, 0, 0)).false_alarm_rate());
  EXPECT_FALSE(detection_at({1, {}, "refused"}).suspect_rate());
}

TEST(Detection, TablesHoldEverySolverAndAxisWithItsInterval) {
  Ladders ladders;
  ladders.axes.resize(2);
  ladders.axes[0].name = "snr";
  ladders.axes[0].title = "Noise";
  ladders.axes[1].name = "rank";
  ladders.axes[1].title = "TSVD: rank";
  SolverEntry one;
  one.label = "a, b";
  SolverEntry two;
  two.label = "tsvd";
  SolverEntry crashed;
  crashed.label = "crash";
  LadderRecord record;
  record.base = level_of(0, 0, 1, 199);
  record.axes = {{"snr", {level_of(0, 2, 1, 197), level_of(79, 182, 0, 0)}}};
  record.axes.front().levels.push_back({2, {}, "impossible"});
  LadderRecord ranks = record;
  ranks.axes = {{"rank", {level_of(0, 20, 0, 180)}}};
  const auto lines = detections_of(
      {{&one, record, ""}, {&two, ranks, ""}, {&crashed, std::nullopt, "crashed: Aborted"}});
  const std::string csv = csv_of(detection_data(lines));
  EXPECT_NE(csv.find("\"a, b\",default,0,0,,,,200,1,0.005,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("\"a, b\",snr,263,79,0.30038,"), std::string::npos) << csv;
  EXPECT_NE(csv.find("tsvd,rank,20,0,0,0,0.161125,180,0,0,0,"), std::string::npos) << csv;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
  EXPECT_EQ(csv.find("crash"), std::string::npos) << "its failure is in breakdown.csv";

  const Table table = detection_table("", ladders, lines);
  ASSERT_EQ(table.sections.size(), 2u);
  const TableSection& detected = table.sections[0];
  ASSERT_EQ(detected.columns.size(), 3u);
  EXPECT_EQ(detected.columns[1].title, "a, b");
  EXPECT_EQ(detected.columns[2].title, "tsvd");
  ASSERT_EQ(detected.rows.size(), 3u);
  EXPECT_EQ(detected.rows[0], (std::vector<Cell>{"The test set itself", "—", "—"}));
  EXPECT_EQ(detected.rows[2][0], "TSVD: rank");
  EXPECT_EQ(detected.rows[2][1], "");
  EXPECT_EQ(detected.rows[2][2].text, "0.0");
  EXPECT_EQ(detected.rows[2][2].interval, "[0.0, 16.1]");
  EXPECT_EQ(detected.rows[2][2].lines, std::vector<std::string>{"0 of 20"});
  const Cell& alarms = table.sections[1].rows[0][1];
  EXPECT_EQ(alarms.text + " " + alarms.interval, "0.5 [0.1, 2.8]");
  EXPECT_EQ(alarms.lines, std::vector<std::string>{"1 of 200"});
}

}  // namespace
}  // namespace ertbench
