#include "bench/studies/collision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/studies/alarm_thresholds.h"
#include "bench/studies/error_statistics.h"
#include "core/random.h"

namespace ertbench {
namespace {

constexpr double frame_rate = 125;  // 1/s

FrameRuns equal_runs(std::size_t sequences, std::size_t frames) {
  FrameRuns runs;
  for (std::size_t s = 0; s <= sequences; ++s) runs.first.push_back(s * frames);
  runs.frame_rate = frame_rate;
  return runs;
}

/// Frames without a touch: exponential magnitudes, whose means differ between regions.
AlarmSignal exponential_signal(std::size_t frames, const std::vector<double>& means,
                               std::uint64_t key) {
  RandomStream random(1, key, 0, Purpose::noise);
  AlarmSignal signal;
  for (std::size_t f = 0; f < frames; ++f) {
    const int region = random.integer(0, static_cast<int>(means.size()) - 1);
    signal.region.push_back(region);
    signal.magnitude.push_back(-means[static_cast<std::size_t>(region)] *
                               std::log(1 - random.uniform()));
  }
  return signal;
}

TEST(AlarmThresholds, ExponentialPeaksAreExtrapolatedToTheRateAskedFor) {
  // 0.13 h are seen and 10 alarms an hour asked for: 1.3 of 60 000 frames. Of unit exponentials
  // ln(450 000 / 10) = 10.71 is exceeded ten times in the 450 000 frames of an hour.
  const FrameRuns runs = equal_runs(20, 3000);
  const std::vector<double> asked = {10};
  const auto fitted =
      fit_thresholds(exponential_signal(runs.frames(), {1}, 1), runs, asked, "test");
  ASSERT_EQ(fitted.size(), 1u);
  // A hundred peaks give the mean excess to a tenth, which the extrapolation by ln(75) = 4.3 makes
  // .43; three standard deviations.
  EXPECT_NEAR(fitted[0].value, std::log(45000.0), 1.3);
  EXPECT_LT(fitted[0].ci95.low, fitted[0].value);
  EXPECT_GT(fitted[0].ci95.high, fitted[0].value);
  EXPECT_NEAR(fitted[0].tail.mean_excess, 1, 0.3);
  EXPECT_FALSE(fitted[0].borrowed);
}

TEST(AlarmThresholds, OtherFramesGiveTheFalseAlarmsAskedForInEveryRegion) {
  const FrameRuns seen = equal_runs(50, 3000);
  const std::vector<double> means = {1, 5};
  const std::vector<double> asked = {150, 50};
  const auto fitted =
      fit_thresholds(exponential_signal(seen.frames(), means, 2), seen, asked, "test");
  const FrameRuns others = equal_runs(500, 3000);  // 3.3 h
  const AlarmSignal quiet = exponential_signal(others.frames(), means, 3);
  const std::vector<double> thresholds = values_of(fitted);
  for (std::size_t region = 0; region < means.size(); ++region) {
    AlarmSignal within = quiet;
    for (std::size_t f = 0; f < within.magnitude.size(); ++f) {
      if (within.region[f] != static_cast<int>(region)) within.magnitude[f] = 0;
    }
    const double per_hour = alarm_count(alarms_of(within, thresholds), others) / others.hours();
    // A hundred peaks: the mean excess to a tenth, times ln of (300 peaks an hour over 50) = 1.8;
    // three standard deviations are a factor of 1.7, and the count's own spread comes to it.
    EXPECT_NEAR(std::log(per_hour / asked[region]), 0, std::log(2.0)) << "region " << region;
  }
}

TEST(AlarmThresholds, ARegionThatNoQuietFrameNamesTakesTheThresholdOfTheSheet) {
  const FrameRuns runs = equal_runs(20, 500);
  const AlarmSignal quiet = exponential_signal(runs.frames(), {1}, 4);
  const std::vector<double> both = {60, 40};
  const std::vector<double> all = {100};
  const auto regions = fit_thresholds(quiet, runs, both, "test");
  EXPECT_TRUE(regions[1].borrowed);
  EXPECT_EQ(regions[1].frames, 0u);
  EXPECT_DOUBLE_EQ(regions[1].value, fit_thresholds(quiet, runs, all, "test")[0].value);
}

TEST(AlarmThresholds, FramesAboveTheStartThatFollowEachOtherAreOnePeak) {
  // 100 frames, a tenth of which lie above the start: five peaks of two frames each.
  AlarmSignal quiet;
  for (int f = 0; f < 100; ++f) quiet.magnitude.push_back(f % 20 < 2 ? 3.0 + f % 20 : 1.0);
  quiet.region.assign(100, 0);
  const std::vector<double> asked = {1};
  const auto fitted = fit_thresholds(quiet, equal_runs(1, 100), asked, "test");
  EXPECT_EQ(fitted[0].tail.peaks, 5);
  EXPECT_DOUBLE_EQ(fitted[0].tail.start, 1);
  EXPECT_DOUBLE_EQ(fitted[0].tail.mean_excess, 3);  // of the larger of the two, 4
}

TEST(AlarmThresholds, AlarmsAreCountedOnceAndEndWithTheirSequence) {
  const FrameRuns runs = equal_runs(2, 5);
  EXPECT_EQ(alarm_count(std::vector<char>{0, 1, 1, 0, 1, 1, 0, 0, 0, 1}, runs), 4);
  EXPECT_EQ(alarm_count(std::vector<char>(10, 1), runs), 2);
  EXPECT_EQ(alarm_count(std::vector<char>(10, 0), runs), 0);
}

TEST(AlarmThresholds, AFrameIsHeldAgainstTheThresholdOfItsRegion) {
  const AlarmSignal signal{{1, 1, 1, NAN, 2, 0}, {0, 1, -1, 0, -1, 0}};
  const std::vector<double> thresholds = {1, 2};
  EXPECT_EQ(alarms_of(signal, thresholds), (std::vector<char>{1, 0, 0, 0, 1, 0}));
}

TEST(AlarmThresholds, PoissonIntervalsAreGarwoods) {
  EXPECT_EQ(poisson_interval(0).low, 0);
  EXPECT_NEAR(poisson_interval(0).high, 3.689, 1e-3);
  EXPECT_NEAR(poisson_interval(1).low, 0.0253, 1e-4);
  EXPECT_NEAR(poisson_interval(1).high, 5.572, 1e-3);
  EXPECT_NEAR(poisson_interval(10).low, 4.795, 1e-3);
  EXPECT_NEAR(poisson_interval(10).high, 18.390, 1e-3);
  EXPECT_NEAR(poisson_interval(100).low, 81.36, 1e-2);
  EXPECT_NEAR(poisson_interval(100).high, 121.63, 1e-2);
  // For many the normal approximation, half a count beside it.
  EXPECT_NEAR(poisson_interval(100000).high, 100000 + 1.96 * std::sqrt(1e5), 3);
  EXPECT_THROW(poisson_interval(-1), std::invalid_argument);
}

TEST(DetectionShare, BinsHoldEquallyManyTrials) {
  std::vector<Trial> trials;
  for (int t = 99; t >= 0; --t) trials.push_back({double(t), t >= 50, std::size_t(t)});
  const auto bins = share_bins(trials, 4);
  ASSERT_EQ(bins.size(), 4u);
  EXPECT_EQ(bins[1].low, 25);
  EXPECT_EQ(bins[1].high, 49);
  EXPECT_EQ(bins[1].successes.count, 0);
  EXPECT_EQ(bins[2].successes.count, 25);
  EXPECT_EQ(share_bins(trials, 50).size(), 5u);
  EXPECT_TRUE(share_bins({}, 4).empty());
}

TEST(DetectionShare, TheLeastForceLiesWhereTheFitCrosses) {
  // Bins of twenty with means 9.5, 29.5, ...: all missed, 10 of 20 found, all found.
  std::vector<Trial> trials;
  for (int t = 0; t < 60; ++t) {
    trials.push_back({double(t), t >= 40 || (t >= 20 && t % 2 == 0), std::size_t(t)});
  }
  const auto found = least_found(trials, 0.95, "test");
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->value, 29.5 + 20 * (0.95 - 0.5) / 0.5, 1e-9);
  EXPECT_LE(found->ci95.low, found->value);
  EXPECT_GE(found->ci95.high, found->value);
}

TEST(DetectionShare, ADipIsPooledAway) {
  // 20 of 20, 10 of 20, 20 of 20: the first two fit as one of 30 in 40, so the third it is.
  std::vector<Trial> trials;
  for (int t = 0; t < 60; ++t) {
    trials.push_back({double(t), t < 20 || t >= 40 || t % 2 == 0, std::size_t(t)});
  }
  const double expected = 29.5 + 20 * (0.95 - 0.75) / 0.25;
  EXPECT_NEAR(least_found(trials, 0.95, "test")->value, expected, 1e-9);
}

TEST(DetectionShare, WhatIsNeverOrAlwaysFoundSaysSo) {
  std::vector<Trial> trials;
  for (int t = 1; t <= 40; ++t) trials.push_back({double(t), false, std::size_t(t)});
  const auto never = least_found(trials, 0.95, "test");
  EXPECT_GT(never->value, never->reach.high);
  EXPECT_EQ(never->reach.high, 40);
  for (Trial& trial : trials) trial.success = true;
  const auto always = least_found(trials, 0.95, "test");
  EXPECT_EQ(always->value, always->reach.low);
  EXPECT_DOUBLE_EQ(always->reach.low, 10.5);
  trials.resize(39);
  EXPECT_FALSE(least_found(trials, 0.95, "test").has_value());
}

TEST(Arm, ThePeakForceIsThatOfTheWayGone) {
  // 0.2 m/s for 10 ms are 2 mm, and v^2 / 2a = 4 mm more: 6 mm at 5 N/mm.
  const ArmSettings settings{5, 5, 10, 140};
  EXPECT_NEAR(settings.peak_force_N(0.2, 0.010), 30, 1e-9);
  EXPECT_NEAR(settings.peak_force_N(settings.highest_speed_m_s(), 0), 10, 1e-9);
  // From rest to rest: 8 mm at 0.2 m/s and 5 m/s² is all speeding up and slowing down; 50 mm takes
  // 0.25 s at that speed and 0.04 s more for its ends.
  EXPECT_NEAR(settings.travel_s(0.2, 0.008), 0.08, 1e-12);
  EXPECT_NEAR(settings.travel_s(0.2, 0.050), 0.29, 1e-12);
  // 6 mm into the obstacle: 0.02 s to stop, 16 mm back in 0.12 s, twice 0.29 s aside, and 16 mm
  // again, 0.08 s and 0.02 s to speed up.
  EXPECT_NEAR(settings.detour_s(0.2, 0.006), 0.02 + 0.12 + 0.58 + 0.10, 1e-12);
}

TEST(Arm, AFrameRaisesItsAlarmWhenTheSolverIsDoneWithIt) {
  const FrameTiming timing{100, 0.0005};  // frames end at 10, 20, 30, ... ms
  const std::vector<char> third = {0, 0, 1, 0, 0, 0};
  EXPECT_NEAR(first_alarm_time(third, timing, 0)->time_s, 0.030, 1e-12);
  EXPECT_NEAR(first_alarm_time(third, timing, 0.004)->time_s, 0.034, 1e-12);
  EXPECT_FALSE(first_alarm_time(std::vector<char>(6, 0), timing, 0).has_value());
}

TEST(Arm, ASlowSolverTakesTheNewestFrameAndDropsTheOthers) {
  // Of 24 ms a frame: the first from 10 to 34 ms, then the third (30 ms) until 58, then the fifth
  // (50 ms) until 82, then the eighth (80 ms).
  const FrameTiming timing{100, 0.0005};
  const auto alarm_of_frame = [&](std::size_t frame) {
    std::vector<char> alarms(8, 0);
    alarms[frame] = 1;
    return first_alarm_time(alarms, timing, 0.024);
  };
  EXPECT_NEAR(alarm_of_frame(0)->time_s, 0.034, 1e-12);
  EXPECT_FALSE(alarm_of_frame(1).has_value());
  EXPECT_NEAR(alarm_of_frame(2)->time_s, 0.058, 1e-12);
  EXPECT_NEAR(alarm_of_frame(2)->frame_end_s, 0.030, 1e-12);
  EXPECT_FALSE(alarm_of_frame(3).has_value());
  EXPECT_NEAR(alarm_of_frame(4)->time_s, 0.082, 1e-12);
  EXPECT_FALSE(alarm_of_frame(5).has_value());
  EXPECT_FALSE(alarm_of_frame(6).has_value());
  EXPECT_NEAR(alarm_of_frame(7)->time_s, 0.106, 1e-12);
}

TEST(Arm, ARunIsDoneNeedlesslyStoppedOrLost) {
  const FrameTiming timing{100, 0.0005};
  const ArmSettings settings{5, 5, 10, 140};
  const ArmTruth truth{0.025, 0.2};
  const ArmRun good = arm_run(std::vector<char>{0, 0, 1, 1, 1, 1}, timing, 0.005, truth, settings);
  EXPECT_TRUE(good.done);
  EXPECT_NEAR(*good.delay_s, 0.010, 1e-12);  // the frame that ends at 30 ms, and 5 ms for it
  EXPECT_NEAR(good.of_latency_s, 0.005, 1e-12);
  EXPECT_NEAR(*good.peak_N, 30, 1e-9);

  const ArmRun early = arm_run(std::vector<char>{0, 1, 1, 1, 1, 1}, timing, 0.005, truth, settings);
  EXPECT_TRUE(early.needless_stop);
  EXPECT_FALSE(early.done);
  EXPECT_FALSE(early.delay_s.has_value());

  const ArmRun lost = arm_run(std::vector<char>(6, 0), timing, 0.005, truth, settings);
  EXPECT_FALSE(lost.done || lost.needless_stop || lost.delay_s || lost.peak_N);

  const auto outcome = arm_outcome({good, early, lost, good}, settings, "test");
  EXPECT_EQ(outcome.done.count, 2);
  EXPECT_EQ(outcome.done.total, 4);
  EXPECT_EQ(outcome.needless.count, 1);
  EXPECT_EQ(outcome.under_limit.count, 2);
  EXPECT_EQ(outcome.under_limit.total, 3);
  EXPECT_EQ(outcome.under_aim.count, 0);
  EXPECT_NEAR(outcome.median_delay_s->value, 0.010, 1e-12);
  EXPECT_EQ(outcome.p95_delay_s->value, ArmOutcome::never_s);
  EXPECT_EQ(outcome.p95_peak_N->value, 140);
  EXPECT_NEAR(outcome.latency_share->value, 0.5, 1e-12);
}

TEST(Arm, WithoutDelayTheHighestSpeedIsThatOfTheBrakes) {
  const ArmSettings settings{5, 5, 10, 140};
  std::vector<ArmRun> runs;
  for (int r = 0; r < 400; ++r) {
    runs.push_back(delayed_run(0, {0.1, 0.1 + 0.001 * r}, settings));
  }
  const auto outcome = arm_outcome(std::move(runs), settings, "test");
  // To the width of a bin of twenty runs.
  EXPECT_NEAR(outcome.highest_speed_m_s->value, settings.highest_speed_m_s(), 0.020);
  EXPECT_NEAR(outcome.highest_speed_m_s->reach.low, 0.1, 1e-12);
  EXPECT_EQ(outcome.median_delay_s->value, 0);
}

TEST(CollisionDetectors, AThresholdForEachRegionFindsWhatOneForAllMisses) {
  // The second half of the sheet is ten times as loud; all presses are in the first.
  CollisionTruth truth;
  truth.region_shares = {0.5, 0.5};
  truth.calibration = equal_runs(20, 1000);
  truth.quiet = equal_runs(20, 1000);
  truth.arm = equal_runs(30, 125);
  truth.arm_timing = {frame_rate, 0.0005};
  DetectorSignals signals;
  signals.calibration = exponential_signal(truth.calibration.frames(), {1, 10}, 5);
  signals.quiet = exponential_signal(truth.quiet.frames(), {1, 10}, 6);
  for (std::size_t p = 0; p < 60; ++p) {
    truth.presses.push_back({1 + 0.01 * double(p), 0, p});
    signals.presses.magnitude.push_back(30);
    signals.presses.region.push_back(0);
  }
  for (std::size_t s = 0; s < 30; ++s) {
    truth.arm_runs.push_back({0.5, 0.1 + 0.01 * double(s)});
    for (int f = 0; f < 125; ++f) {
      signals.arm.magnitude.push_back((f + 1) / frame_rate > 0.5 ? 30 : 0.1);
      signals.arm.region.push_back(0);
    }
  }
  const ArmSettings arm{5, 5, 10, 140};
  Detector regional =
      assess_detector("solver", AlarmRule::by_region, signals, truth, 10, 0.001, arm);
  EXPECT_EQ(regional.least_N->value, regional.least_N->reach.low);
  EXPECT_EQ(regional.arm.done.count, 30);
  EXPECT_FALSE(regional.least_by_region_N[1].has_value());

  DetectorSignals whole = signals;
  for (AlarmSignal* signal : {&whole.calibration, &whole.quiet, &whole.presses, &whole.arm}) {
    std::fill(signal->region.begin(), signal->region.end(), 0);
  }
  const Detector global =
      assess_detector("solver", AlarmRule::one_threshold, whole, truth, 10, 0.001, arm);
  EXPECT_GT(global.least_N->value, global.least_N->reach.high);
  EXPECT_EQ(global.arm.done.count, 0);
}

}  // namespace
}  // namespace ertbench
