#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "core/statistics.h"

namespace ertbench {
namespace {

using Values = std::vector<double>;

TEST(Quantile, InterpolatedOnesAreThoseOfNumpyAndR) {
  // quantile(c(15, 20, 35, 40, 50), c(.05, .3, .4, .95)) in R, whose default is type 7.
  const SortedValues values = Values{40, 15, 50, 35, 20};
  EXPECT_DOUBLE_EQ(interpolated_quantile(values, 0.05), 16);
  EXPECT_DOUBLE_EQ(interpolated_quantile(values, 0.3), 23);
  EXPECT_DOUBLE_EQ(interpolated_quantile(values, 0.4), 29);
  EXPECT_DOUBLE_EQ(interpolated_quantile(values, 0.95), 48);
  EXPECT_EQ(interpolated_quantile(values, 0), 15);
  EXPECT_EQ(interpolated_quantile(values, 1), 50);
}

TEST(Quantile, NearestRankIsAValueThatAtLeastTheShareDoNotExceed) {
  // The same five values in the example of Wikipedia's "Percentile", nearest rank.
  const SortedValues values = Values{40, 15, 50, 35, 20};
  EXPECT_EQ(nearest_rank_quantile(values, 0.05), 15);
  EXPECT_EQ(nearest_rank_quantile(values, 0.3), 20);
  EXPECT_EQ(nearest_rank_quantile(values, 0.4), 20);
  EXPECT_EQ(nearest_rank_quantile(values, 0.5), 35);
  EXPECT_EQ(nearest_rank_quantile(values, 1), 50);
  EXPECT_EQ(nearest_rank_quantile(values, 0), 15);
  EXPECT_EQ(nearest_rank(1000, 0.99), 989u);
  EXPECT_EQ(nearest_rank(4, 0.5), 1u);  // of two in the middle the smaller
}

TEST(Quantile, TheMedianOfAnEvenNumberIsTheMeanOfTheTwoInTheMiddle) {
  EXPECT_DOUBLE_EQ(median(Values{4, 1, 2, 100}), 3);
  EXPECT_EQ(median(Values{7, -1, 3}), 3);
  EXPECT_EQ(median(Values{2}), 2);
}

TEST(Quantile, TheUpperMedianIsReachedByAtLeastHalfOfTheValues) {
  EXPECT_EQ(upper_median(Values{4, 1, 2, 100}), 4);
  EXPECT_EQ(upper_median(Values{7, -1, 3}), 3);
  EXPECT_EQ(upper_median(Values{2}), 2);
  EXPECT_THROW(upper_median(Values{}), std::invalid_argument);
}

TEST(Quantile, RefusesWhatHasNone) {
  EXPECT_THROW(median(Values{}), std::invalid_argument);
  EXPECT_THROW(nearest_rank(0, 0.5), std::invalid_argument);
  EXPECT_THROW(interpolated_quantile(Values{1, 2}, 1.01), std::invalid_argument);
  EXPECT_THROW(nearest_rank_quantile(Values{1, 2}, -0.01), std::invalid_argument);
}

TEST(Moments, MeanAndSampleDeviation) {
  EXPECT_DOUBLE_EQ(mean(Values{2, 4, 4, 4, 5, 5, 7, 9}), 5);
  EXPECT_DOUBLE_EQ(sample_deviation(Values{1, 3}), 1.4142135623730951);
  EXPECT_EQ(mean(Values{1e308, 1.5e308}), 1.25e308);  // no overflow
  EXPECT_THROW(mean(Values{}), std::invalid_argument);
  EXPECT_THROW(sample_deviation(Values{1}), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
