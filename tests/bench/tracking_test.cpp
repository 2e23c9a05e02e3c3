#include "bench/studies/tracking.h"

#include <gtest/gtest.h>

#include <cmath>

#include "forward/sheet/sensor.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

WritePlan plan_for(const std::string& characters, double size_mm = 120) {
  WritePlan plan;
  plan.characters = characters;
  plan.size_mm = size_mm;
  return plan;
}

TouchSequence written(const WritePlan& plan, std::uint64_t sequence = 0) {
  RandomStream random(1, 0, sequence, Purpose::scene);
  return SequenceSet(plan, {}).draw(sequence, random, Sensor{});
}

std::optional<Vector2d> finger_of(const TouchSequence& truth, double time_s) {
  for (const Touch& touch : truth.at(time_s)) {
    if (touch.force_N > 0) return touch.place_mm;
  }
  return std::nullopt;
}

/// What a solver without error finds.
std::vector<StreamFrame> perfect_frames(const TouchSequence& truth, const FrameTiming& timing) {
  std::vector<StreamFrame> frames;
  for (int n = 0; timing.end_s(n) <= truth.duration_s; ++n) {
    StreamFrame frame{timing.middle_s(n, 16), timing.end_s(n), {}};
    if (const auto finger = finger_of(truth, frame.middle_s)) frame.contacts_mm = {*finger};
    frames.push_back(frame);
  }
  return frames;
}

TrackedCharacter track(const WritePlan& plan, const FrameTiming& timing, double latency_s) {
  const TouchSequence truth = written(plan);
  return track_character(truth, perfect_frames(truth, timing), latency_s,
                         CharacterReader(plan.size_mm));
}

std::vector<std::size_t> frames_of(const std::vector<StreamReport>& reports) {
  std::vector<std::size_t> out;
  for (const StreamReport& report : reports) out.push_back(report.frame);
  return out;
}

std::vector<StreamFrame> frames_each_second(int count) {
  std::vector<StreamFrame> frames;
  for (int n = 0; n < count; ++n) frames.push_back({n + 0.5, n + 1.0, {{1, 2}}});
  return frames;
}

TEST(TrackingStream, TheNewestFrameWins) {
  // Begun at 1, 3.5 (frame 2 ended at 3 and took the place of frame 1), 6 and 8.5; frame 8, which
  // ends at 9, finds the solver busy until 11, as does frame 9.
  const auto reports = follow_stream(frames_each_second(10), 2.5);
  EXPECT_EQ(frames_of(reports), (std::vector<std::size_t>{0, 2, 5, 7, 9}));
  const std::vector<double> out_s = {3.5, 6, 8.5, 11, 13.5};
  for (std::size_t i = 0; i < out_s.size(); ++i) EXPECT_NEAR(reports[i].out_s, out_s[i], 1e-12);
}

TEST(TrackingStream, ASolverThatIsFastEnoughDropsNothing) {
  for (const double latency_s : {0.0, 0.3, 1.0}) {
    const auto reports = follow_stream(frames_each_second(4), latency_s);
    EXPECT_EQ(frames_of(reports), (std::vector<std::size_t>{0, 1, 2, 3}));
    EXPECT_NEAR(reports[3].out_s, 4 + latency_s, 1e-12);
  }
}

TEST(TrackingStream, NothingIsReportedBeforeATrackIsConfirmedAndWhereItIsNot) {
  std::vector<StreamFrame> frames;
  for (int n = 0; n < 4; ++n) frames.push_back({0.01 * n, 0.01 * n + 0.004, {{10, 20}}});
  frames[2].contacts_mm.clear();        // the track is still where it was
  frames[3].contacts_mm = {{-80, 20}};  // something else, which no second frame has shown
  const auto reports = follow_stream(frames, 0);
  EXPECT_FALSE(reports[0].place_mm);
  EXPECT_LT((reports[1].place_mm.value() - Vector2d(10, 20)).norm(), 1e-9);
  EXPECT_LT((reports[2].place_mm.value() - Vector2d(10, 20)).norm(), 1e-9);
  EXPECT_FALSE(reports[3].place_mm);
}

TEST(TrackingRun, PerfectReadingsWithoutLatencyFollowTheFinger) {
  const WritePlan plan = plan_for("S");  // 100 mm/s
  const TrackedCharacter one = track(plan, {500, 0.0001}, 0);
  // What is known is between 0.8 ms (half a frame's drives) and 2.8 ms old, and the tracker smooths
  // over a few frames.
  EXPECT_LT(one.rms_mm.value(), 0.7);
  EXPECT_LT(one.rms_without_lag_mm.value(), 0.5);
  EXPECT_GT(one.lag_s.value(), 0.0008);
  EXPECT_LT(one.lag_s.value(), 0.006);
  EXPECT_LT(one.frechet_mm.value(), 4);  // the corner of the path that the tracker cuts
  EXPECT_EQ(one.frames, one.worked_on);
  EXPECT_LE(one.lost, 1);  // before the track is confirmed
  EXPECT_EQ(one.ghosts, 0);
}

TEST(TrackingRun, ALatencyOfThreeFramesDropsTwoOfThreeAndIsTheLeastLag) {
  const WritePlan plan = plan_for("O");  // 100 mm/s
  const FrameTiming timing{100, 0.0005};
  const TrackedCharacter fast = track(plan, timing, 0);
  const TrackedCharacter slow = track(plan, timing, 3 / timing.frame_rate);
  EXPECT_EQ(fast.worked_on, fast.frames);
  // Frames 0, 3, 6, ..., and the last one, which waits for no newer.
  EXPECT_GE(slow.worked_on, slow.frames / 3);
  EXPECT_LE(slow.worked_on, slow.frames / 3 + 2);
  EXPECT_GT(slow.lag_s.value(), 3 / timing.frame_rate);
  // Three frames for the work, and one more on average until the next report.
  EXPECT_NEAR(*slow.lag_s - *fast.lag_s, 4 / timing.frame_rate, 0.5 / timing.frame_rate);
  // At 100 mm/s, 40 ms are 4 mm.
  EXPECT_GT(*slow.rms_mm, *fast.rms_mm + 2.5);
  EXPECT_LT(*slow.rms_without_lag_mm, *slow.rms_mm / 2);
}

TEST(TrackingRun, EveryCharacterIsReadBackFromItself) {
  for (const double size_mm : {60.0, 120.0}) {
    const CharacterReader reader(size_mm);
    const WritePlan plan = plan_for("0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ", size_mm);
    for (std::uint64_t s = 0; s < plan.characters.size(); ++s) {
      const TouchSequence truth = written(plan, s);
      const TrackedCharacter one = track_character(truth, perfect_frames(truth, {}), 0.001, reader);
      EXPECT_TRUE(one.read_back()) << one.name << " read as " << one.read_as;
      EXPECT_TRUE(one.frechet_mm) << one.name;
    }
  }
}

TEST(TrackingRun, WhereNothingIsFoundNothingIsDefined) {
  const WritePlan plan = plan_for("T");
  const TouchSequence truth = written(plan);
  std::vector<StreamFrame> frames = perfect_frames(truth, {});
  for (StreamFrame& frame : frames) frame.contacts_mm.clear();
  const TrackedCharacter one = track_character(truth, frames, 0, CharacterReader(plan.size_mm));
  EXPECT_FALSE(one.rms_mm);
  EXPECT_FALSE(one.lag_s);
  EXPECT_FALSE(one.frechet_mm);
  EXPECT_EQ(one.read_as, "");
  EXPECT_FALSE(one.read_back());
  EXPECT_GT(one.touched, 0);
  EXPECT_EQ(one.lost, one.touched);
  const std::vector<TrackedCharacter> all = {one, one};
  const TrackingScores scores = tracking_scores(all, "test");
  EXPECT_FALSE(scores.rms_mm);
  EXPECT_EQ(scores.with_rms, 0);
  EXPECT_EQ(scores.drop_outs->value, 1);
  EXPECT_EQ(scores.read_back->value, 0);
  EXPECT_GT(scores.read_back->ci95.high, 0.3);  // two of two say little
}

TEST(TrackingRun, GhostsAreFarFromTheFingerOrWithoutOne) {
  const WritePlan plan = plan_for("I");
  const TouchSequence truth = written(plan);
  std::vector<StreamFrame> frames = perfect_frames(truth, {});
  for (StreamFrame& frame : frames) frame.contacts_mm.emplace_back(0, 95);
  int ghosts = 0;
  for (std::size_t n = 1; n < frames.size(); ++n) {  // confirmed in the second frame
    const auto finger = finger_of(truth, frames[n].middle_s);
    if (!finger || (*finger - Vector2d(0, 95)).norm() > kGhostDistance) ++ghosts;
  }
  const TrackedCharacter one = track_character(truth, frames, 0, CharacterReader(plan.size_mm));
  // A few frames at the ends of strokes and of the circle around the ghost may go either way.
  EXPECT_NEAR(one.ghosts, ghosts, 10);
  EXPECT_GT(ghosts, 100);
}

TrackedCharacter scored(const char* name, double rms_mm, const char* read_as, int lost) {
  TrackedCharacter one;
  one.name = name;
  one.rms_mm = rms_mm;
  one.read_as = read_as;
  one.frames = 20;
  one.worked_on = 10;
  one.touched = 8;
  one.lost = lost;
  return one;
}

TEST(TrackingScores, ByHand) {
  const std::vector<TrackedCharacter> all = {scored("A", 2, "A", 0), scored("A", 4, "A", 2),
                                             scored("B", 6, "8", 4)};
  const TrackingScores scores = tracking_scores(all, "test");
  EXPECT_DOUBLE_EQ(scores.rms_mm->value, 4);
  EXPECT_DOUBLE_EQ(scores.drop_outs->value, 6 / 24.0);
  EXPECT_DOUBLE_EQ(scores.dropped_frames->value, 0.5);
  EXPECT_DOUBLE_EQ(scores.read_back->value, 2 / 3.0);
  // Both A stay together: the means of resamples are 3, 4 and 6.
  EXPECT_DOUBLE_EQ(scores.rms_mm->ci95.low, 3);
  EXPECT_DOUBLE_EQ(scores.rms_mm->ci95.high, 6);
  EXPECT_FALSE(scores.lag_ms);
  EXPECT_FALSE(scores.frechet_mm);
}

TEST(TrackingScores, TheLeastFrameRateThatIsEnough) {
  const std::vector<RateValue> shares = {{500, 1.0}, {125, 0.96}, {30, 0.94}, {10, std::nullopt}};
  EXPECT_EQ(enough_frame_rate(shares, true), 125);
  const std::vector<RateValue> errors = {{10, 9}, {30, 2.09}, {125, 2}, {500, 2.2}};
  EXPECT_EQ(enough_frame_rate(errors, false), 30);
  EXPECT_FALSE(enough_frame_rate({}, false));
  const std::vector<RateValue> none = {{10, 0.0}, {30, 0.0}};
  EXPECT_FALSE(enough_frame_rate(none, true));
}

TrackingCondition condition_of(double speed_mm_s, double frame_rate, double rms_mm) {
  TrackingCondition out{"set", speed_mm_s, frame_rate, 120, "finger, 2 N", "50 dB absolute", {}};
  TrackingOfSolver good{"good", "", 0.002, {scored("A", rms_mm, "A", 0)}, {}};
  good.scores = tracking_scores(good.characters, "test");
  out.solvers = {good, {"bad", "crashed: Aborted", std::nullopt, {}, {}}};
  return out;
}

TEST(TrackingTables, ShowEverySolverAndOnlyWhatWasMeasured) {
  const std::vector<TrackingCondition> conditions = {
      condition_of(100, 30, 5), condition_of(100, 125, 3), condition_of(400, 125, 9)};
  const TableSection table = tracking_table(conditions.front(), "falling");
  table.require_cells();
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(table.rows[1][0].lines, std::vector<std::string>{"crashed: Aborted"});
  EXPECT_EQ(table.rows[1][2].text, "—");
  EXPECT_NE(table.caption.find("50 dB absolute, falling law"), std::string::npos);
  const TableSection data = tracking_data(conditions, "falling");
  data.require_cells();
  EXPECT_EQ(data.rows.size(), 6u);

  // 400 mm/s were measured at one frame rate alone, which says nothing.
  const auto tables = frame_rate_tables(conditions, "falling");
  ASSERT_EQ(tables.size(), 2u);
  for (const TableSection& one : tables) {
    one.require_cells();
    ASSERT_EQ(one.columns.size(), 2u);
    EXPECT_EQ(one.rows[1][1].text, "—");
  }
  EXPECT_EQ(tables[0].rows[0][1].text, "30");   // "A" is read back at both
  EXPECT_EQ(tables[1].rows[0][1].text, "125");  // the RMS distance is 5 mm at 30
}

}  // namespace
}  // namespace ertbench
