#include "bench/score/bootstrap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <vector>

namespace ertbench {
namespace {

using Values = std::vector<std::optional<double>>;

constexpr unsigned kSeed = 20240611;

/// Uniform on [0, 1), the same on every platform.
double uniform(std::mt19937_64& generator) {
  return static_cast<double>(generator() >> 11U) * 0x1p-53;
}

Values uniforms(std::mt19937_64& generator, int count) {
  Values values;
  for (int i = 0; i < count; ++i) values.emplace_back(uniform(generator));
  return values;
}

TEST(Bootstrap, CoversTheMeanAsOftenAsItSays) {
  // The percentile interval is mean +- 1.960 sqrt((n - 1) / n) standard errors up to O(1/n) for a
  // symmetric distribution; with n = 50, Student's distribution gives 94.3 % for it. Over 400 sets
  // the standard deviation of the share is sqrt(.943 .057 / 400) = 1.16 %; bound: four of them.
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 generator(kSeed);
  constexpr int sets = 400;
  int covered = 0;
  for (int set = 0; set < sets; ++set) {
    const MetricSummary summary = summarise(uniforms(generator, 50), "PE");
    covered += summary.ci95->low <= 0.5 && 0.5 <= summary.ci95->high ? 1 : 0;
  }
  EXPECT_NEAR(covered / double(sets), 0.943, 4 * 0.0116);
}

TEST(Bootstrap, TheMediansIntervalReachesToTheOrderStatisticsOfTheBinomialDistribution) {
  // Tables of the sign test: for n = 10 the second and the ninth value (97.9 %), for 50 the 18th
  // and the 33rd (96.7 %), and nothing reaches 95 % with five.
  const auto ends = [](int count) {
    Values values;
    for (int i = count; i >= 1; --i) values.emplace_back(i);
    return summarise(values, "AR").median_ci95;
  };
  EXPECT_EQ(ends(10), (Interval{2, 9}));
  EXPECT_EQ(ends(50), (Interval{18, 33}));
  EXPECT_EQ(ends(6), (Interval{1, 6}));
  EXPECT_FALSE(ends(5).has_value());
  EXPECT_EQ(ends(1000), (Interval{469, 532}));
}

TEST(Bootstrap, EachEndLiesWhereTheStandardErrorSays) {
  // A 2.5 % quantile out of R = 2000 draws has the relative standard deviation
  // sqrt(.025 .975 / R) / (1.96 density(1.96)) = 3.0 %; over 20 sets .67 %: bound, four of them.
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 generator(kSeed);
  constexpr int sets = 20;
  double below = 0;  // distances from the mean in standard errors
  double above = 0;
  for (int set = 0; set < sets; ++set) {
    const Values values = uniforms(generator, 1000);
    double mean = 0;
    for (const auto& value : values) mean += *value / 1000;
    double variance = 0;
    for (const auto& value : values) variance += std::pow(*value - mean, 2) / 1000;
    const double standard_error = std::sqrt(variance / 1000);
    const MetricSummary summary = summarise(values, "RIE");
    EXPECT_NEAR(summary.mean.value(), mean, 1e-12);
    below += (mean - summary.ci95->low) / standard_error / sets;
    above += (summary.ci95->high - mean) / standard_error / sets;
  }
  EXPECT_NEAR(below, 1.960, 4 * 0.0067 * 1.960);
  EXPECT_NEAR(above, 1.960, 4 * 0.0067 * 1.960);
}

TEST(Bootstrap, IsDeterministicAndKeyedByTheName) {
  std::mt19937_64 generator(kSeed);
  const Values values = uniforms(generator, 37);
  EXPECT_EQ(summarise(values, "AR"), summarise(values, "AR"));
  EXPECT_NE(summarise(values, "AR").ci95, summarise(values, "PE").ci95);
  EXPECT_EQ(summarise(values, "AR").mean, summarise(values, "PE").mean);
}

TEST(Bootstrap, QuantilesOfABinomial) {
  // As many zeros as ones: a resampled mean is a binomial share. Of four draws it is 0 or 1 with a
  // probability of 1/16 each, above 2.5 %: the interval is all of [0, 1], exactly.
  EXPECT_EQ(summarise(Values{0, 1, 0, 1}, "AR").ci95, (Interval{0, 1}));
  // Of ten: P(mean <= .1) = 1.07 %, P(mean <= .2) = 5.5 %, each known to .5 % by 2000 draws. The
  // ends differ from .2 and .8 by the rounding of sums of tenths.
  const Interval ten = summarise(Values{0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, "AR").ci95.value();
  EXPECT_NEAR(ten.low, 0.2, 1e-15);
  EXPECT_NEAR(ten.high, 0.8, 1e-15);
}

TEST(Bootstrap, UndefinedFramesAreCountedAndEnterNothingElse) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const Values some = {1.0, std::nullopt, 2.0, nan, 6.0, infinity};
  const MetricSummary summary = summarise(some, "AR");
  EXPECT_EQ(summary.count, 3);
  EXPECT_EQ(summary.undefined, 3);
  EXPECT_DOUBLE_EQ(summary.mean.value(), 3);
  EXPECT_DOUBLE_EQ(summary.median.value(), 2);
  MetricSummary alone = summarise(Values{1.0, 2.0, 6.0}, "AR");
  EXPECT_EQ(summary.ci95, alone.ci95);
}

TEST(Bootstrap, NothingOrOneFrame) {
  const MetricSummary none = summarise(Values{std::nullopt, std::nullopt}, "AR");
  EXPECT_EQ(none, (MetricSummary{std::nullopt, std::nullopt, std::nullopt, 0, 2}));
  EXPECT_EQ(summarise(Values{}, "AR"), MetricSummary{});
  const MetricSummary one = summarise(Values{0.25}, "AR");
  EXPECT_EQ(one, (MetricSummary{0.25, Interval{0.25, 0.25}, 0.25, 1, 0}));
}

TEST(Bootstrap, MedianOfAnEvenNumberIsTheMiddle) {
  EXPECT_DOUBLE_EQ(summarise(Values{4.0, 1.0, 2.0, 100.0}, "AR").median.value(), 3);
}

TEST(Bootstrap, SummarisesEachMetricOfTheFrames) {
  std::vector<FrameMetrics> frames(3);
  frames[0][Metric::AR] = 1;
  frames[1][Metric::AR] = 2;
  frames[2][Metric::RIE] = 0.5;
  const PerMetric<MetricSummary> summaries = summarise(frames);
  EXPECT_DOUBLE_EQ(summaries[Metric::AR].mean.value(), 1.5);
  EXPECT_EQ(summaries[Metric::AR].undefined, 1);
  EXPECT_DOUBLE_EQ(summaries[Metric::RIE].mean.value(), 0.5);
  EXPECT_EQ(summaries[Metric::PE].undefined, 3);
}

}  // namespace
}  // namespace ertbench
