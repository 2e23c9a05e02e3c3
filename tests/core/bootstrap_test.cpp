#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "core/statistics.h"

namespace ertbench {
namespace {

using Values = std::vector<double>;

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
    const Interval interval = bootstrap_interval_of_mean(uniforms(generator, 50), "PE");
    covered += interval.low <= 0.5 && 0.5 <= interval.high ? 1 : 0;
  }
  EXPECT_NEAR(covered / double(sets), 0.943, 4 * 0.0116);
}

TEST(MedianInterval, ReachesToTheOrderStatisticsOfTheBinomialDistribution) {
  // Tables of the sign test: for n = 10 the second and the ninth value (97.9 %), for 50 the 18th
  // and the 33rd (96.7 %), and nothing reaches 95 % with five.
  const auto ends = [](int count) {
    Values values;
    for (int i = count; i >= 1; --i) values.emplace_back(i);
    return binomial_median_interval(values);
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
    const double middle = mean(values);
    const double standard_error = sample_deviation(values) / std::sqrt(1000);
    const Interval interval = bootstrap_interval_of_mean(values, "RIE");
    below += (middle - interval.low) / standard_error / sets;
    above += (interval.high - middle) / standard_error / sets;
  }
  EXPECT_NEAR(below, 1.960, 4 * 0.0067 * 1.960);
  EXPECT_NEAR(above, 1.960, 4 * 0.0067 * 1.960);
}

TEST(Bootstrap, RatiosOfSumsHaveTheErrorOfTheDeltaMethod) {
  std::mt19937_64 generator(kSeed);
  const Values below = uniforms(generator, 1000);
  Values above = uniforms(generator, 1000);
  for (std::size_t i = 0; i < above.size(); ++i) above[i] += 2 * below[i];
  const auto found = ratio_of_sums(above, below, "pairs");
  EXPECT_NEAR(found->ratio, mean(above) / mean(below), 1e-12);
  Values residuals;
  for (std::size_t i = 0; i < above.size(); ++i) {
    residuals.push_back((above[i] - found->ratio * below[i]) / mean(below));
  }
  const double standard_error = sample_deviation(residuals) / std::sqrt(1000);
  EXPECT_NEAR((found->ci95.high - found->ci95.low) / standard_error, 2 * 1.96, 0.3);
  // One value that is a multiple of the other leaves nothing to chance.
  for (std::size_t i = 0; i < above.size(); ++i) above[i] = 3 * below[i];
  EXPECT_NEAR(ratio_of_sums(above, below, "pairs")->ci95.high, 3, 1e-12);
  const Values nothing = {0, 0};
  EXPECT_FALSE(ratio_of_sums(nothing, nothing, "none"));
  EXPECT_FALSE(ratio_of_sums({}, {}, "none"));
}

TEST(Bootstrap, IsDeterministicAndKeyedByTheName) {
  std::mt19937_64 generator(kSeed);
  const Values values = uniforms(generator, 37);
  const Interval interval = bootstrap_interval_of_mean(values, "AR");
  EXPECT_EQ(bootstrap_interval_of_mean(values, "AR"), interval);
  EXPECT_NE(bootstrap_interval_of_mean(values, "PE"), interval);
}

TEST(Bootstrap, QuantilesOfABinomial) {
  // As many zeros as ones: a resampled mean is a binomial share. Of four draws it is 0 or 1 with a
  // probability of 1/16 each, above 2.5 %: the interval is all of [0, 1], exactly.
  EXPECT_EQ(bootstrap_interval_of_mean(Values{0, 1, 0, 1}, "AR"), (Interval{0, 1}));
  // Of ten: P(mean <= .1) = 1.07 %, P(mean <= .2) = 5.5 %, each known to .5 % by 2000 draws. The
  // ends differ from .2 and .8 by the rounding of sums of tenths.
  const Interval ten = bootstrap_interval_of_mean(Values{0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, "AR");
  EXPECT_NEAR(ten.low, 0.2, 1e-15);
  EXPECT_NEAR(ten.high, 0.8, 1e-15);
}

TEST(Bootstrap, OfOneValueIsThatValueAndOfNoneNothing) {
  EXPECT_EQ(bootstrap_interval_of_mean(Values{0.25}, "AR"), (Interval{0.25, 0.25}));
  EXPECT_THROW(bootstrap_interval_of_mean({}, "AR"), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
