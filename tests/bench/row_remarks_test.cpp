
#include <gtest/gtest.h>

#include "bench/report/result_table.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/table/table.h"

namespace ertbench {
namespace {

ResultRow made_row(const std::string& label, double error, const std::string& cpu,
                   double busy = 0) {
  ResultRow row;
  row.label = row.family = label;
  row.type = label == "no-contact" ? label : "tsvd";
  row.dataset = "test";
  row.frames = 10;
  row.metrics[Metric::relative_error].mean = error;
  row.metrics[Metric::relative_error].median = error;
  if (cpu.empty()) return row;
  row.latency_us = LatencySummary{5, 6, 7, {}, {}};
  row.frames_per_s = 1000;
  row.timed_on = TimingPlace{cpu, "node1", busy};
  return row;
}

const std::vector<ResultRow>& rows() {
  static const std::vector<ResultRow> all = {
      made_row("no-contact", 1, ""), made_row("a", 0.5, "Xeon"), made_row("b", 0.6, "Epyc", 1.5),
      made_row("c", 1.01, "Xeon"), made_row("d", 1, "")};
  return all;
}

TEST(RowRemarks, ARowThatIsWorseThanNothingSaysSo) {
  EXPECT_FALSE(worse_than_no_contact(rows()[0], rows()));
  EXPECT_FALSE(worse_than_no_contact(rows()[1], rows()));
  EXPECT_TRUE(worse_than_no_contact(rows()[3], rows()));
  EXPECT_FALSE(worse_than_no_contact(rows()[4], rows()));  // as good as nothing
  ResultRow elsewhere = rows()[3];
  elsewhere.dataset = "other";  // which has no row of nothing
  EXPECT_FALSE(worse_than_no_contact(elsewhere, rows()));
  const std::string text = markdown_of(result_table(rows(), TableText()));
  EXPECT_NE(text.find("worse than no contact"), std::string::npos) << text;
  EXPECT_NE(terminal_of(result_summary(rows())).find("worse than no contact"), std::string::npos);
}

TEST(RowRemarks, ClocksOfTwoProcessorsAreNotCompared) {
  EXPECT_EQ(usual_processor(rows()), "Xeon");
  EXPECT_TRUE(timed_elsewhere(rows()[2], "Xeon"));
  EXPECT_FALSE(timed_elsewhere(rows()[4], "Xeon"));
  const std::vector<std::string> remarks = timing_remarks(rows());
  ASSERT_EQ(remarks.size(), 2u);
  EXPECT_NE(remarks[0].find("b (Epyc)"), std::string::npos) << remarks[0];
  EXPECT_NE(remarks[1].find("b (1.5)"), std::string::npos) << remarks[1];
  EXPECT_NE(markdown_of(result_table(rows(), TableText())).find("5.00 †"), std::string::npos);
  SpeedQuestion question;
  question.dataset = "test";
  question.labels = {"a", "b", "c"};
  question.budgets_us = {100};
  const SpeedAccuracy chart = speed_accuracy_of(question, rows());
  EXPECT_TRUE(chart.points[0].measured());
  EXPECT_FALSE(chart.points[1].measured());
  EXPECT_NE(chart.points[1].remark.find("another processor"), std::string::npos);
  EXPECT_EQ(chart.choices.at(3).point, std::optional<std::size_t>(0));
  EXPECT_TRUE(timing_remarks({rows().data(), 2}).empty());
}

TEST(RowRemarks, FitTimesOfSeedsThatDifferAreSaid) {
  std::vector<ResultRow> fitted = {made_row("alike", 0.5, "Xeon", 0),
                                   made_row("odd", 0.5, "Xeon", 0)};
  fitted[0].seeds.emplace().fit_s = {329, 330, std::nullopt};
  fitted[1].seeds.emplace().fit_s = {329, 330, 40};
  EXPECT_EQ(fitted[1].seeds->usual_fit_s(), 329);
  EXPECT_FALSE(SeedSpread().usual_fit_s());
  const std::vector<std::string> remarks = timing_remarks(fitted);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("odd (40 to 330 s)"), std::string::npos) << remarks[0];
  EXPECT_EQ(remarks[0].find("alike"), std::string::npos) << remarks[0];
}

TEST(RowRemarks, ASolversOwnProcessDoesNotDisturbIt) {
  std::vector<ResultRow> programs = {made_row("alone", 0.5, "Xeon", 1.0),
                                     made_row("disturbed", 0.5, "Xeon", 1.5)};
  for (ResultRow& row : programs) row.latency_us->pipe = 2;
  const std::vector<std::string> remarks = timing_remarks(programs);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("disturbed (0.5)"), std::string::npos) << remarks[0];
  EXPECT_EQ(remarks[0].find("alone"), std::string::npos) << remarks[0];
}

}  // namespace
}  // namespace ertbench
