// The table of metrics: what its readers rely on, whatever the metrics are.

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/score/metrics.h"

namespace ertbench {
namespace {

TEST(MetricTable, NamesAreTheirOwnAndLeadBack) {
  std::set<std::string> names;
  for (const MetricEntry& entry : kMetricTable) {
    const std::string name = entry.name;
    EXPECT_TRUE(names.insert(name).second) << name << " stands twice";
    EXPECT_EQ(name.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_0123456"
                                     "789"),
              std::string::npos)
        << name << " is not a name by the schema of experiments";
    EXPECT_EQ(metric_from_name(name), entry.metric);
    EXPECT_STREQ(name_of(entry.metric), entry.name);
  }
  EXPECT_THROW(metric_from_name("ar"), std::invalid_argument);
}

TEST(MetricTable, FormerNamesAreStillRead) {
  EXPECT_EQ(metric_from_name("found"), Metric::detected);
  EXPECT_EQ(metric_from_name("ghosts"), Metric::false_positives);
  const auto key_among = [](const std::set<std::string>& keys) {
    return key_in_file(Metric::false_positives,
                       [&](const char* key) { return keys.contains(key); });
  };
  EXPECT_STREQ(key_among({"ghosts"}), "ghosts");
  EXPECT_STREQ(key_among({"ghosts", "false_positives"}), "false_positives");
  EXPECT_EQ(key_among({"AR"}), nullptr);
  const std::vector<std::string> accepted = accepted_names(kErrorMetrics);
  EXPECT_NE(std::find(accepted.begin(), accepted.end(), "ghosts"), accepted.end());
  EXPECT_EQ(accepted.size(), kErrorMetrics.size() + 1);
}

TEST(MetricTable, IntervalsOfARenamedMetricStayAsTheyWerePublished) {
  const std::vector<FrameMetrics> frames = [] {
    std::vector<FrameMetrics> out(20);
    for (std::size_t i = 0; i < out.size(); ++i) out[i][Metric::false_positives] = (i * i) % 7;
    return out;
  }();
  std::vector<std::optional<double>> values;
  for (const FrameMetrics& frame : frames) values.push_back(frame[Metric::false_positives]);
  EXPECT_EQ(summarise(frames)[Metric::false_positives], summarise(values, "ghosts"));
}

TEST(MetricTable, EveryEntryIsComplete) {
  for (const MetricEntry& entry : kMetricTable) {
    SCOPED_TRACE(entry.name);
    for (const char* text : {entry.title, entry.heading, entry.legend}) EXPECT_STRNE(text, "");
    EXPECT_TRUE(std::string(entry.legend).ends_with('.')) << "a legend is a sentence";
    EXPECT_NE(entry.formula, nullptr);
    // An error is judged by itself, and its ideal is 0.
    const Metric distance = entry.distance;
    EXPECT_TRUE(distance == entry.metric || is_error(entry_of(distance)));
    EXPECT_EQ(entry_of(distance).distance, distance);
    if (is_error(entry)) {
      EXPECT_EQ(entry.ideal.value, 0);
      EXPECT_FALSE(entry.ideal.of_truth);
    }
  }
}

TEST(MetricTable, DistancesGrowAwayFromTheIdeal) {
  for (const MetricEntry& entry : kMetricTable) {
    SCOPED_TRACE(entry.name);
    const std::optional<double> truth = 0.8 * typical_magnitude(entry.quantity);
    const double ideal = ideal_of(entry.metric, truth).value();
    const double step = 0.1 * typical_magnitude(entry.quantity);
    const auto at = [&](double value) { return distance_from_ideal(entry.metric, value, truth); };
    EXPECT_EQ(at(ideal), 0);
    if (entry.better != Better::larger) {
      EXPECT_GT(at(ideal + 2 * step), at(ideal + step));
    }
    if (entry.better != Better::smaller) {
      EXPECT_GT(at(ideal - 2 * step), at(ideal - step));
    }
  }
}

TEST(MetricTable, TextsOfAxesIdealsAndDistances) {
  EXPECT_EQ(axis_title(Metric::RES_error), "|RES − truth| (%)");
  EXPECT_EQ(axis_title(Metric::PE), "PE (sheet 2 × 2)");
  EXPECT_EQ(axis_title(Metric::relative_error), "relative error of δσ");
  EXPECT_EQ(ideal_text(Metric::RES, 82.777), "truth 82.78");
  EXPECT_EQ(ideal_text(Metric::AR, 1), "ideal 1");
  EXPECT_EQ(ideal_of(Metric::RES, std::nullopt), std::nullopt);
  EXPECT_EQ(distance_title(Metric::AR), "|AR − 1|");
  EXPECT_EQ(distance_title(Metric::RES), "|RES − truth|");
  EXPECT_EQ(distance_title(Metric::RIE), "RIE");
  EXPECT_EQ(distance_title(Metric::CC), "1 − CC of δσ");
}

TEST(MetricTable, ChoicesFollowFromTheEntries) {
  for (const Metric metric : kErrorMetrics) EXPECT_EQ(entry_of(metric).better, Better::smaller);
  EXPECT_EQ(names_of(kPublishedMetrics), (std::vector<std::string>{"AR", "RES", "PE", "RIE"}));
  EXPECT_EQ(names_of(kMetrics).size(), kMetricTable.size());
}

}  // namespace
}  // namespace ertbench
