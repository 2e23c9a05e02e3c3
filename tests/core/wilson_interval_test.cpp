#include <gtest/gtest.h>

#include <stdexcept>

#include "core/statistics.h"

namespace ertbench {
namespace {

// Newcombe, Two-sided confidence intervals for the single proportion, Statistics in Medicine 17
// (1998) 857-872, table I, method 3: four decimals.
TEST(WilsonInterval, IsThePublishedOne) {
  const auto expect = [](int count, int total, double low, double high) {
    const Interval interval = wilson_interval(count, total);
    EXPECT_NEAR(interval.low, low, 5e-5) << count << " of " << total;
    EXPECT_NEAR(interval.high, high, 5e-5) << count << " of " << total;
  };
  expect(81, 263, 0.2553, 0.3662);
  expect(15, 148, 0.0624, 0.1605);
  expect(0, 20, 0.0000, 0.1611);
  expect(1, 29, 0.0061, 0.1718);
}

TEST(WilsonInterval, OfTheOthersIsItsMirrorImage) {
  for (const int count : {0, 1, 7, 20}) {
    const Interval interval = wilson_interval(count, 20);
    const Interval others = wilson_interval(20 - count, 20);
    EXPECT_NEAR(interval.low, 1 - others.high, 1e-15);
    EXPECT_LE(interval.low, count / 20.0);
    EXPECT_GE(interval.high, count / 20.0);
  }
}

TEST(WilsonInterval, EndsAtNoneAndAllExactly) {
  for (int total = 1; total <= 1000; ++total) {
    EXPECT_EQ(wilson_interval(0, total).low, 0) << total;
    EXPECT_EQ(wilson_interval(total, total).high, 1) << total;
  }
}

TEST(WilsonInterval, RefusesWhatIsNoShare) {
  EXPECT_THROW(wilson_interval(0, 0), std::invalid_argument);
  EXPECT_THROW(wilson_interval(-1, 5), std::invalid_argument);
  EXPECT_THROW(wilson_interval(6, 5), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
