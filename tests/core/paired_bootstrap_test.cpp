#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/random.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

/// Frames of very different difficulty, which all samples share, and a noise of their own.
Eigen::MatrixXd sample(int seeds, int frames, double offset, double seed_deviation,
                       std::uint64_t number) {
  RandomStream difficulty(1, 0, 0, Purpose::noise);
  RandomStream own(2, number, 0, Purpose::noise);
  Eigen::MatrixXd out(seeds, frames);
  for (int s = 0; s < seeds; ++s) {
    const double of_seed = seed_deviation * own.normal();
    for (int f = 0; f < frames; ++f) out(s, f) = offset + of_seed + 0.01 * own.normal();
  }
  for (int f = 0; f < frames; ++f) out.col(f).array() += difficulty.normal();
  return out;
}

TEST(PairedBootstrap, WhatFramesShareDropsOutOfADifference) {
  const std::vector<Eigen::MatrixXd> samples = {sample(1, 400, 0.0, 0, 1),
                                                sample(1, 400, 0.005, 0, 2)};
  const PairedBootstrap bootstrap(samples, "test");
  EXPECT_NEAR(bootstrap.difference(1, 0), 0.005, 0.003);
  const Interval interval = bootstrap.interval(1, 0);
  // The difference of a frame deviates by 0.0141, its mean over 400 by 0.00071; unpaired it would
  // be 0.07.
  EXPECT_NEAR(interval.high - interval.low, 2 * 1.96 * 0.0141 / 20, 4e-4);
  EXPECT_GT(interval.low, 0);
  const Interval turned = bootstrap.interval(0, 1);
  EXPECT_DOUBLE_EQ(turned.low, -interval.high);
}

/// With seeds that deviate by s the difference of two means over n seeds deviates by s sqrt(2 / n),
/// which frames alone do not show.
TEST(PairedBootstrap, SeedsAreASecondLevel) {
  double squares = 0;
  double widths = 0;
  constexpr int repetitions = 400;
  for (std::uint64_t r = 0; r < repetitions; ++r) {
    const std::vector<Eigen::MatrixXd> samples = {sample(4, 20, 0, 0.1, 2 * r + 10),
                                                  sample(4, 20, 0, 0.1, 2 * r + 11)};
    const PairedBootstrap bootstrap(samples, "test");
    squares += std::pow(bootstrap.difference(0, 1), 2);
    const Interval interval = bootstrap.interval(0, 1);
    widths += interval.high - interval.low;
  }
  const double deviation = 0.1 * std::sqrt(2.0 / 4);
  EXPECT_NEAR(std::sqrt(squares / repetitions), deviation, 0.15 * deviation);  // of 400: 3.5 %
  EXPECT_NEAR(widths / repetitions, 2 * 1.96 * deviation, 0.15 * 2 * 1.96 * deviation);
}

TEST(PairedBootstrap, NeedsTheSameFrames) {
  const std::vector<Eigen::MatrixXd> samples = {Eigen::MatrixXd::Zero(1, 5),
                                                Eigen::MatrixXd::Zero(1, 6)};
  EXPECT_THROW(PairedBootstrap(samples, "test"), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
