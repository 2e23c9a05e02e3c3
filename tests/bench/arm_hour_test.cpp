// The simulated time on the arm: what happens in it, how it is judged, and the study as the program
// makes it.

#include "bench/studies/arm_hour.h"

#include <gtest/gtest.h>

#include <cmath>

#include "forward/border/border_model.h"
#include "forward/data/sheet_model.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

TEST(ArmHour, IsDrawnFromItsSeedAndPressesOnceForASixth) {
  const ArmHour hour(Sensor{}, {.minutes = 60, .frame_rate = 10, .seed = 3});
  EXPECT_EQ(hour.frames(), 36000);
  ASSERT_GT(hour.touches().size(), 100u);
  double longest_s = 0;
  for (std::size_t t = 0; t < hour.touches().size(); ++t) {
    const HourTouch& touch = hour.touches()[t];
    longest_s = std::max(longest_s, touch.end_s - touch.begin_s);
    EXPECT_LT(touch.end_s, 3600);
    if (t == 0) continue;
    EXPECT_GE(touch.begin_s, hour.touches()[t - 1].end_s + 3) << "never two at once";
  }
  EXPECT_NEAR(longest_s, 600, 1e-9);

  Eigen::RowVectorXd one(Sensor{}.channels());
  Eigen::RowVectorXd same(Sensor{}.channels());
  Eigen::RowVectorXd other(Sensor{}.channels());
  hour.frame(20000, one);
  ArmHour(Sensor{}, {.minutes = 60, .frame_rate = 10, .seed = 4}).frame(20000, other);
  ArmHour(Sensor{}, {.minutes = 60, .frame_rate = 10, .seed = 3}).frame(20000, same);
  EXPECT_EQ(one, same);
  EXPECT_NE(one, other);
}

TEST(ArmHour, BeginsWithNoiseAndHumAlone) {
  const ArmHour hour(Sensor{}, {.minutes = 1, .snr_db = 50});
  const Eigen::VectorXd reference = uniform_reference(Sensor{});
  double squares = 0;
  constexpr int frames = 200;
  Eigen::RowVectorXd change(Sensor{}.channels());
  for (int f = 0; f < frames; ++f) {
    hour.frame(f, change);
    squares += change.squaredNorm();
  }
  // Noise of 50 dB and hum of a thousandth, 208 x 200 numbers: the deviation is 1 %.
  EXPECT_NEAR(squares / frames / reference.squaredNorm(), 1e-5 + 1e-6, 3e-7);
}

TEST(ArmHour, HasAnElectrodeThatComesLooseAndReadsZero) {
  const Sensor sensor;
  const ArmHour hour(sensor, {.minutes = 2});
  const Eigen::RowVectorXd reference = BorderModel(sensor).reference_voltages().transpose();
  int frames = 0;
  Eigen::RowVectorXd change(sensor.channels());
  for (Eigen::Index f = 0; f < hour.frames(); f += 10) {
    hour.frame(f, change);
    const auto zero = ((change + reference).array().abs() < 1e-9 * reference.norm()).count();
    if (zero == 0) continue;
    ++frames;
    // Two drive pairs have the electrode, with 13 channels each; by reciprocity as many measure
    // with it.
    EXPECT_EQ(zero, 52);
    EXPECT_TRUE(hour.is_eventful(f));
  }
  EXPECT_GE(frames, 10) << "a second or longer, every tenth frame of 100 a second";
}

/// Ten seconds at 50 frames a second with a press from 2 to 4 s and a touch from 6 to 7 s.
class HourJudgement : public ::testing::Test {
 protected:
  using Contacts = std::vector<Vector2d>;
  template <typename Detect>
  HourScores scores(const Detect& detect) {
    HourJudge judge(touches_, 10);
    for (int f = 0; f < 500; ++f) judge.see(f / 50.0, detect(f / 50.0));
    return judge.scores(10);
  }
  /// Where the contact is, if one is there.
  Contacts truth(double time_s) const {
    Contacts out;
    for (const HourTouch& touch : touches_) {
      if (time_s >= touch.begin_s && time_s <= touch.end_s) out.push_back(touch.place_mm);
    }
    return out;
  }
  const std::vector<HourTouch> touches_ = {{2, 4, true, {30, 0}, {}}, {6, 7, false, {-20, 40}, {}}};
};

TEST_F(HourJudgement, OfTheTruthIsPerfect) {
  const HourScores scores = this->scores([&](double time_s) { return truth(time_s); });
  EXPECT_EQ(scores.presses, 1);
  EXPECT_EQ(scores.touches, 1);
  EXPECT_EQ(scores.presses_missed + scores.touches_missed + scores.false_alarms, 0);
  EXPECT_GT(scores.seen, 0.95);
  EXPECT_NEAR(*scores.error_mm, 0, 1e-6);
  EXPECT_FALSE(scores.fails_min);
}

TEST_F(HourJudgement, OfNothingMissesAllAndFailsWithThePress) {
  const HourScores scores = this->scores([](double) { return Contacts{}; });
  EXPECT_EQ(scores.presses_missed, 1);
  EXPECT_EQ(scores.touches_missed, 1);
  EXPECT_EQ(scores.seen, 0);
  EXPECT_FALSE(scores.error_mm);
  EXPECT_NEAR(*scores.fails_min, 4.0 / 60, 1e-9);
}

TEST_F(HourJudgement, CountsFalseAlarmsAndFailsAtALongOne) {
  const HourScores scores = this->scores([&](double time_s) {
    Contacts out = truth(time_s);
    const bool is_short = time_s >= 0.5 && time_s <= 0.8;
    if (is_short || (time_s >= 8 && time_s <= 9.5)) out.emplace_back(50, -50);
    return out;
  });
  EXPECT_EQ(scores.false_alarms, 2);
  EXPECT_NEAR(scores.false_alarms_h, 720, 1e-9);
  EXPECT_NEAR(scores.false_share, 0.18, 0.01);
  EXPECT_NEAR(*scores.fails_min, 9.0 / 60, 0.1 / 60);
  EXPECT_EQ(scores.presses_missed + scores.touches_missed, 0);
}

TEST_F(HourJudgement, OfAContactFarFromItsPlaceIsMissAndFalseAlarm) {
  const HourScores scores = this->scores([&](double time_s) {
    Contacts out = truth(time_s);
    for (Vector2d& one : out) one.x() += 25;
    return out;
  });
  EXPECT_EQ(scores.presses_missed, 1);
  EXPECT_EQ(scores.false_alarms, 2);
}

TEST(ArmHourStudy, OfTwoMinutesIsATableWithAndWithoutReReference) {
  const TemporaryFolder folder;
  nlohmann::json experiment = testing::small_experiment();
  experiment["solvers"] = {{{"type", "one-step-gn"}, {"lambda", "auto"}}};
  experiment["studies"] = {{{"type", "arm_hour"}, {"minutes", 2}, {"frame_rate", 20}}};
  testing::write_text(folder / "e.json", experiment.dump());
  const testing::Outcome outcome = testing::run_program(folder.path(), "run e.json --out results");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const nlohmann::json rows =
      testing::summary_of(folder / "results")["studies"]["arm_hour"]["solvers"]["one-step-gn"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0]["reference"], "first");
  EXPECT_EQ(rows[1]["reference"], "re-taken");
  EXPECT_GT(rows[0]["presses"].get<int>() + rows[0]["touches"].get<int>(), 4);
  EXPECT_LT(rows[0]["presses_missed"], rows[0]["presses"]) << "a press is seen by any method";
  EXPECT_TRUE(std::filesystem::exists(folder / "results/arm_hour.csv"));
}

}  // namespace
}  // namespace ertbench
