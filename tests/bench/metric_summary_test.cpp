#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <vector>

#include "bench/score/metrics.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

using Values = std::vector<std::optional<double>>;

TEST(MetricSummary, UndefinedFramesAreCountedAndEnterNothingElse) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const Values some = {1.0, std::nullopt, 2.0, nan, 6.0, infinity};
  const MetricSummary summary = summarise(some, "AR");
  EXPECT_EQ(summary.count, 3);
  EXPECT_EQ(summary.undefined, 3);
  EXPECT_DOUBLE_EQ(summary.mean.value(), 3);
  EXPECT_DOUBLE_EQ(summary.median.value(), 2);
  EXPECT_EQ(summary.ci95, bootstrap_interval_of_mean(std::vector{1.0, 2.0, 6.0}, "AR"));
}

TEST(MetricSummary, NothingOrOneFrame) {
  const MetricSummary none = summarise(Values{std::nullopt, std::nullopt}, "AR");
  EXPECT_EQ(none, (MetricSummary{std::nullopt, std::nullopt, std::nullopt, 0, 2}));
  EXPECT_EQ(summarise(Values{}, "AR"), MetricSummary{});
  const MetricSummary one = summarise(Values{0.25}, "AR");
  EXPECT_EQ(one, (MetricSummary{0.25, Interval{0.25, 0.25}, 0.25, 1, 0}));
}

TEST(MetricSummary, MedianOfAnEvenNumberIsTheMiddle) {
  EXPECT_DOUBLE_EQ(summarise(Values{4.0, 1.0, 2.0, 100.0}, "AR").median.value(), 3);
}

TEST(MetricSummary, SummarisesEachMetricOfTheFrames) {
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
