// Comparison with a baseline: what each class of tolerances lets pass, and every verdict.

#include "bench/check/check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/check/tolerance.h"
#include "bench/table/table.h"
#include "core/errors.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr int frames = 200;
const CheckContext this_machine{"this cpu"};

ResultRow result(const std::string& label, const std::string& type) {
  ResultRow row;
  row.label = label;
  row.type = type;
  row.dataset = "test";
  row.frames = frames;
  for (const Metric metric : kMetrics) row.metrics[metric].mean = 0.6;
  for (const auto& [metric, mean] :
       {std::pair{Metric::AR, 1.2}, std::pair{Metric::RES, 76.0}, std::pair{Metric::RES_error, 7.5},
        std::pair{Metric::PE, 0.035}, std::pair{Metric::PE25, 0.02}, std::pair{Metric::RIE, 0.05},
        std::pair{Metric::relative_error, 0.7}}) {
    row.metrics[metric].mean = mean;
  }
  row.latency_us = LatencySummary{10, 12, 20, {9, 10, 14}, {3, 3.3, 4.7}};
  row.calibration_us = 3;
  row.frames_per_s = 1e6;
  return row;
}

ResultRow true_row() {
  ResultRow row = result("truth", "truth");
  row.metrics[Metric::AR].mean = 1;
  row.metrics[Metric::RES].mean = 82;
  for (const Metric metric : {Metric::RES_error, Metric::RIE, Metric::relative_error}) {
    row.metrics[metric].mean = 0;
  }
  row.latency_us.reset();
  return row;
}

std::optional<ImageComparison> comparison_of(const ResultRow& row) {
  if (row.label == "truth") return std::nullopt;
  if (row.label == "net") return ImageComparison::seeds;
  return row.label == "tv" ? ImageComparison::duality_gap : ImageComparison::rounding;
}

BaselineRow baseline_row(const ResultRow& row) {
  BaselineRow out;
  out.label = row.label;
  out.dataset = row.dataset;
  out.tolerance = tolerance_of(row, comparison_of(row));
  out.status = row.status;
  out.frames = row.frames;
  for (const Metric metric : kMetrics) out.metrics[metric] = {*row.metrics[metric].mean};
  out.times = relative_times(row);
  return out;
}

/// The truth, and a row of each class.
struct Case {
  Case()
      : rows{true_row(), result("gn", "one-step-gn"), result("tv", "pdipm"),
             result("net", "fcnn")} {
    baseline.cpu = this_machine.cpu;
    for (const ResultRow& row : rows) {
      baseline.rows.push_back(baseline_row(row));
    }
    BaselineRow& net = baseline.rows.back();
    net.seeds = {1, 2, 3, 4, 5};
    for (const Metric metric : kMetrics) {
      const double mean = net.metrics[metric].front();
      net.metrics[metric] = {0.98 * mean, 0.99 * mean, mean, 1.01 * mean, 1.02 * mean};
    }
  }

  ResultRow& row(const std::string& label) {
    return *std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.label == label; });
  }
  std::vector<CheckLine> lines() const { return compare(baseline, rows, this_machine); }

  /// The verdict on one quantity.
  Verdict verdict(const std::string& label, const std::string& quantity) const {
    for (const CheckLine& line : lines()) {
      if (line.row == label && line.quantity == quantity) return line.verdict;
    }
    throw std::runtime_error("no line " + label + " " + quantity);
  }

  /// After a change of one metric of one row.
  Verdict after(const std::string& label, Metric metric, double change) {
    std::optional<double>& mean = row(label).metrics[metric].mean;
    const std::optional<double> before = mean;
    *mean += change;
    const Verdict verdict = this->verdict(label, name_of(metric));
    mean = before;
    return verdict;
  }

  Baseline baseline;
  std::vector<ResultRow> rows;
};

TEST(Check, TheSameNumbersAreOk) {
  const std::vector<CheckLine> lines = Case().lines();
  for (const CheckLine& line : lines) {
    EXPECT_EQ(line.verdict, Verdict::ok) << line.row << " " << line.quantity;
  }
  EXPECT_FALSE(has_regression(lines));
  EXPECT_EQ(check_summary(lines), "4 rows ok");
}

struct Step {
  const char* row;
  Metric metric;
  double passes;   ///< a change in the wrong direction that is allowed
  double refused;  ///< one that is not
};

TEST(Check, EachClassPassesASmallChangeAndRefusesALargerOne) {
  // Seeds: s = sqrt(2.5) 0.01 of the mean, t(0.9995, 4) = 8.610, sqrt(1 + 1/5): 0.1491 of the mean.
  // One pixel: 100 / (24 200) = 0.0208 of RES; with 1 + 576 0.24^2 = 34.2 bright pixels
  // sqrt(8) / (2 34.2 200) = 2.07e-4 of PE25.
  const Step steps[] = {
      {"truth", Metric::RIE, 0.9e-10, 1.2e-10},
      {"truth", Metric::RES, 0.9e-8, -1.2e-8},
      {"truth", Metric::PE25, 0.9e-10, 1.2e-10},
      {"gn", Metric::relative_error, 0.9e-8, 1.1e-8},
      {"gn", Metric::AR, 1.1e-8, 1.3e-8},
      {"gn", Metric::PE, 0.9e-8, 1.1e-8},
      {"gn", Metric::RES, -0.0208, -0.0209},
      {"gn", Metric::RES_error, 0.0208, 0.0209},
      {"gn", Metric::PE25, 2.0e-4, 2.1e-4},
      {"tv", Metric::relative_error, 0.69e-3, 0.71e-3},
      {"tv", Metric::RIE, 0.49e-4, 0.51e-4},
      {"tv", Metric::RES, -0.096, -0.098},
      {"net", Metric::relative_error, 0.149 * 0.7, 0.150 * 0.7},
      {"net", Metric::RES, -0.149 * 76, -0.150 * 76},
  };
  for (const Step& step : steps) {
    SCOPED_TRACE(std::string(step.row) + " " + name_of(step.metric));
    Case c;
    EXPECT_EQ(c.after(step.row, step.metric, step.passes), Verdict::ok);
    EXPECT_EQ(c.after(step.row, step.metric, step.refused), Verdict::worse);
  }
}

TEST(Check, BetterIsTowardsTheIdealOfTheMetric) {
  Case c;
  for (const Metric metric : kErrorMetrics) {
    SCOPED_TRACE(name_of(metric));
    // One contact in one of 200 frames may be worth 50 mm, 0.25 mm in the mean.
    const bool length = entry_of(metric).quantity == Quantity::millimetres;
    const double step = length ? 0.3 : 0.1 * *c.row("gn").metrics[metric].mean;
    EXPECT_EQ(c.after("gn", metric, -step), Verdict::better);
    EXPECT_EQ(c.after("gn", metric, step), Verdict::worse);
  }
  EXPECT_EQ(c.after("gn", Metric::AR, -0.1), Verdict::better);  // 1.1
  EXPECT_EQ(c.after("gn", Metric::AR, -0.4), Verdict::worse);   // 0.8: as far from 1
  EXPECT_EQ(c.after("gn", Metric::AR, -0.5), Verdict::worse);
  EXPECT_EQ(c.after("gn", Metric::RES, 3), Verdict::better);  // the truth's is 82
  EXPECT_EQ(c.after("gn", Metric::RES, 13), Verdict::worse);
  EXPECT_EQ(c.after("net", Metric::relative_error, -0.2), Verdict::better);
  for (const MetricEntry& entry : kMetricTable) {
    if (entry.better != Better::larger) continue;
    SCOPED_TRACE(entry.name);
    EXPECT_EQ(c.after("gn", entry.metric, 0.1), Verdict::better);
    EXPECT_EQ(c.after("gn", entry.metric, -0.1), Verdict::worse);
  }

  c.row("gn").metrics[Metric::PE].mean = 0.01;
  EXPECT_FALSE(has_regression(c.lines()));
  EXPECT_EQ(check_summary(c.lines()), "3 rows ok, 1 better");
}

TEST(Check, OneContactInOneFrameIsNoRegressionAndTwoAre) {
  // 200 frames; trained networks that never showed a ghost have no spread.
  const double none[] = {0, 0, 0};
  const Tolerance seeds{ToleranceClass::seeds, 1e-4};
  EXPECT_DOUBLE_EQ(allowed_change(seeds, {Metric::false_positives, none, 200}), 1.0 / 200);
  const Tolerance linear{ToleranceClass::linear, 1e-8};
  const double one[] = {0.5};
  EXPECT_NEAR(allowed_change(linear, {Metric::recall, one, 200}), 1.0 / 200, 1e-7);
  EXPECT_NEAR(allowed_change(linear, {Metric::ospa_mm, one, 200}), 50.0 / 200, 2e-6);
  const Tolerance exact{ToleranceClass::exact, 1e-10};
  EXPECT_LT(allowed_change(exact, {Metric::detected, one, 200}), 1e-9) << "none of the truth";
}

// As tables of the test print it: of 252 choices of five of ten, 1 + 1 + 2 have a U of 0, 1 and 2.
TEST(Check, ARankSumHasTheChanceOfThePrintedTables) {
  const auto chance = [](const std::vector<double>& before, const std::vector<double>& now) {
    return rank_sum_chance(before, now);
  };
  EXPECT_DOUBLE_EQ(chance({1, 2, 3, 4, 7}, {5, 6, 8, 9, 10}), 4.0 / 252);
  EXPECT_DOUBLE_EQ(chance({5, 6, 8, 9, 10}, {1, 2, 3, 4, 7}), 4.0 / 252);
  EXPECT_DOUBLE_EQ(chance({1, 1, 1}, {1, 1}), 1);
  // Ranks 2.5 four times, 5 and 6: of 15 pairs, four have 2.5 + 6 and one has 5 + 6.
  EXPECT_DOUBLE_EQ(chance({0, 0, 0, 1}, {2, 0}), 5.0 / 15);
}

TEST(Check, OneTrainingWithManyGhostsIsNoWorseningOfAll) {
  const std::vector<double> before = {.015, .02,  .02, .025, .025, .025,
                                      .02,  .015, .03, .02,  .025, .02};
  std::vector<std::optional<double>> now = {.03, .02, .02, .025, .025, .3, .025, .015};
  const auto beyond = [&](Metric metric) {
    double sum = 0;
    for (const std::optional<double>& value : now) sum += *value;
    return is_beyond({ToleranceClass::seeds, 1e-4}, {metric, before, 200},
                     {sum / static_cast<double>(now.size()), now});
  };
  EXPECT_TRUE(beyond(Metric::relative_error)) << "which no rare event makes";
  EXPECT_FALSE(beyond(Metric::false_positives));
  for (std::optional<double>& value : now) *value += 0.03;
  EXPECT_TRUE(beyond(Metric::false_positives)) << "all of them have more";
}

TEST(Check, ATrainingWithoutAMeanIsNotRanked) {
  const std::vector<double> before = {0, 0, 0, 0, 0};
  const std::vector<std::optional<double>> now = {0.0, 0.0, std::nullopt};
  const Tolerance seeds{ToleranceClass::seeds, 1e-4};
  EXPECT_TRUE(is_beyond(seeds, {Metric::false_positives, before, 200}, {0.1, now}));
}

TEST(Check, TheIntervalIsNarrowerForMoreSeedsAndNeverVanishes) {
  const double values[] = {0.4, 0.41, 0.42, 0.43, 0.44, 0.41, 0.42, 0.43};
  const Tolerance seeds{ToleranceClass::seeds, 1e-4};
  const auto allowed = [&](std::span<const double> before, int now) {
    return allowed_change(seeds, {Metric::relative_error, before, 200, Sensor{}, std::nullopt},
                          now);
  };
  EXPECT_LT(allowed(values, 1), allowed(std::span(values).first(5), 1));
  // 1 + 1/8 against 1/3 + 1/8 in the root
  EXPECT_NEAR(allowed(values, 1) / allowed(values, 3), std::sqrt(1.125 / (1.0 / 3 + 0.125)), 1e-12);
  const double same[] = {0.4, 0.4, 0.4};
  EXPECT_NEAR(allowed(same, 1), 31.599 * 0.4e-4 * std::sqrt(4.0 / 3), 1e-6);
}

TEST(Check, DualityGapSetsTheToleranceOfAnInteriorPointSolver) {
  ResultRow row = result("tv", "pdipm");
  EXPECT_DOUBLE_EQ(tolerance_of(row, ImageComparison::duality_gap).relative, 1e-3);
  row.parameters = nlohmann::json{{"alpha", 1e-6}, {"tolerance", 1e-6}};
  EXPECT_DOUBLE_EQ(tolerance_of(row, ImageComparison::duality_gap).relative, 1e-4);
}

TEST(Check, CountsAreExact) {
  Case c;
  c.row("gn").undefined_frames = 1;
  c.row("tv").frames_not_converged = 1;
  c.row("net").frames = frames - 1;
  EXPECT_EQ(c.verdict("gn", "undefined frames"), Verdict::worse);
  EXPECT_EQ(c.verdict("tv", "frames not converged"), Verdict::worse);
  EXPECT_EQ(c.verdict("net", "frames"), Verdict::worse);
  c.baseline.rows[1].undefined_frames = 2;
  EXPECT_EQ(c.verdict("gn", "undefined frames"), Verdict::better);
}

TEST(Check, FailedMissingAndNewRowsAreNamed) {
  Case c;
  ResultRow& failed = c.row("gn");
  failed.status = "crashed";
  failed.message = "Aborted";
  failed.frames = 0;
  failed.metrics = {};
  EXPECT_EQ(c.verdict("gn", "status"), Verdict::worse);
  c.row("tv").label = "tv renamed";
  EXPECT_EQ(c.verdict("tv", "row"), Verdict::missing);
  EXPECT_EQ(c.verdict("tv renamed", "row"), Verdict::missing);
  EXPECT_TRUE(has_regression(c.lines()));
  EXPECT_EQ(check_summary(c.lines()), "2 rows ok, 2 missing, 1 worse");

  c.baseline.rows[1].status = "crashed";  // it always did
  c.baseline.rows[1].frames = 0;
  c.baseline.rows[1].metrics = {};
  c.baseline.rows[1].times.reset();
  EXPECT_EQ(c.verdict("gn", "status"), Verdict::ok);
  failed = result("gn", "one-step-gn");
  EXPECT_EQ(c.verdict("gn", "status"), Verdict::better);

  Case lost;
  lost.baseline.rows.erase(lost.baseline.rows.begin() + 1);
  EXPECT_TRUE(has_regression(lost.lines()));
}

TEST(Check, AMetricThatBecameUndefinedIsWorse) {
  Case c;
  c.row("gn").metrics[Metric::PE].mean.reset();
  EXPECT_EQ(c.verdict("gn", "PE"), Verdict::worse);
  c.baseline.rows[1].metrics[Metric::PE].clear();
  EXPECT_EQ(c.verdict("gn", "PE"), Verdict::ok);
  c.row("gn").metrics[Metric::PE].mean = 0.1;
  EXPECT_EQ(c.verdict("gn", "PE"), Verdict::missing);  // the baseline has lost it
  c.row("gn").metrics[Metric::RIE].mean = std::nan("");
  EXPECT_EQ(c.verdict("gn", "RIE"), Verdict::worse);
}

TEST(Check, AMetricThatTheBaselineDoesNotKnowIsNotCompared) {
  Case c;
  std::erase(c.baseline.metrics, Metric::CC);
  c.row("gn").metrics[Metric::CC].mean = 0;
  EXPECT_THROW(c.verdict("gn", "CC"), std::runtime_error);  // has no line
  EXPECT_EQ(check_summary(c.lines()), "4 rows ok");
}

TEST(Check, TheStoredBaselinesAreRead) {
  const std::filesystem::path folder =
      std::filesystem::path(ERTBENCH_SOURCE_DIR) / "results/baselines";
  int files = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".json") continue;
    SCOPED_TRACE(file.path());
    const Baseline baseline = read_baseline(file.path());
    ASSERT_FALSE(baseline.rows.empty());
    EXPECT_NE(std::find(baseline.metrics.begin(), baseline.metrics.end(), Metric::relative_error),
              baseline.metrics.end());
    // What it does not know is not written either.
    const json written = json::parse(to_json_text(baseline));
    EXPECT_EQ(written.at("rows").at(0).at("metrics").size(), baseline.metrics.size());
    ++files;
  }
  EXPECT_GT(files, 0);
}

TEST(Check, TimesAreComparedAsMultiplesOfTheCalibration) {
  Case c;
  ResultRow& gn = c.row("gn");
  gn.latency_us->relative_of_rounds = {3, 3.3, 4.7};  // a machine three times slower
  gn.calibration_us = 9;
  gn.frames_per_s = 1e6 / 3;
  EXPECT_EQ(c.verdict("gn", "latency / calibration"), Verdict::ok);
  EXPECT_EQ(c.verdict("gn", "batch frame / calibration"), Verdict::ok);
  gn = result("gn", "one-step-gn");
  gn.latency_us->relative_of_rounds = {3.3, 3.2, 30, 30, 3.1};  // disturbed in two rounds of five
  EXPECT_EQ(c.verdict("gn", "latency / calibration"), Verdict::ok);
  gn.latency_us->relative_of_rounds = {4.2, 4.2, 4.1};
  EXPECT_EQ(c.verdict("gn", "latency / calibration"), Verdict::slower);
  EXPECT_TRUE(has_regression(c.lines()));
  gn.frames_per_s = 0.34e6;
  EXPECT_EQ(c.verdict("gn", "batch frame / calibration"), Verdict::ok);
  gn.frames_per_s = 0.32e6;
  EXPECT_EQ(c.verdict("gn", "batch frame / calibration"), Verdict::slower);
  c.baseline.cpu = "another cpu";
  EXPECT_EQ(c.verdict("gn", "latency / calibration"), Verdict::slower_warning);
  EXPECT_FALSE(has_regression(c.lines()));
  c.baseline.cpu = this_machine.cpu;
  gn.latency_us->relative_of_rounds = {2, 2, 2};
  EXPECT_EQ(c.verdict("gn", "latency / calibration"), Verdict::better);
  gn.latency_us.reset();
  EXPECT_EQ(c.verdict("gn", "latency / calibration"), Verdict::missing);
  Case lost;
  lost.baseline.rows[1].times.reset();
  EXPECT_EQ(lost.verdict("gn", "latency / calibration"), Verdict::missing);
}

TEST(Check, TheTableShowsWhatChangedAndALineForEachRow) {
  Case c;
  *c.row("gn").metrics[Metric::relative_error].mean += 1e-6;
  const std::string table = terminal_of(check_table(c.lines(), false));
  EXPECT_NE(table.find("row    quantity             old       new            notices  verdict\n"),
            std::string::npos)
      << table;
  EXPECT_NE(table.find("gn     relative_error       0.7  0.700001  1e-08 (1.4e-06 %)  worse\n"),
            std::string::npos)
      << table;
  const std::size_t others = 6;  // status, three counts, two times
  const std::string quantities = std::to_string(kMetrics.size() + others - 1) + " of " +
                                 std::to_string(kMetrics.size() + others) + " quantities";
  EXPECT_NE(table.find("gn     " + quantities), std::string::npos) << table;
  EXPECT_EQ(table.find("PE25"), std::string::npos) << table;
  const std::string all = terminal_of(check_table(c.lines(), true));
  EXPECT_NE(all.find("PE25"), std::string::npos) << all;
  EXPECT_NE(markdown_of(check_report(c.lines())).find("| gn    | relative_error "),
            std::string::npos)
      << markdown_of(check_report(c.lines()));
}

TEST(Check, RowsOfSeveralTestSetsAreToldApart) {
  Case c;
  ResultRow fine = result("gn", "one-step-gn");
  fine.dataset = "fine";
  c.rows.push_back(fine);
  EXPECT_EQ(c.verdict("gn (fine)", "row"), Verdict::missing);
  EXPECT_EQ(c.verdict("gn (test)", "PE"), Verdict::ok);
}

TEST(Check, ABaselineComesBackAsItWas) {
  const testing::TemporaryFolder folder("baseline");
  Case c;
  c.baseline.experiment = "small";
  c.baseline.provenance = nlohmann::json{{"cpu", "this cpu"}};
  c.baseline.rows[1].entry = nlohmann::json{{"lambda", 0.1}, {"type", "one-step-gn"}};
  c.baseline.rows[2].metrics[Metric::PE].clear();
  c.baseline.networks = {"net"};
  const std::string text = to_json_text(c.baseline);
  testing::write_text(folder / "small.json", text);
  const Baseline read = read_baseline(folder / "small.json");
  EXPECT_EQ(to_json_text(read), text);
  EXPECT_EQ(read.cpu, "this cpu");
  EXPECT_EQ(read.rows[3].seeds, c.baseline.rows[3].seeds);
  EXPECT_EQ(read.rows[3].metrics[Metric::AR], c.baseline.rows[3].metrics[Metric::AR]);
  EXPECT_TRUE(read.rows[2].metrics[Metric::PE].empty());
  EXPECT_EQ(read.rows[1].times, c.baseline.rows[1].times);
  EXPECT_EQ(read.rows[2].tolerance, c.baseline.rows[2].tolerance);
}

TEST(Check, AMalformedBaselineIsRefusedWithThePlace) {
  const testing::TemporaryFolder folder("malformed");
  Case c;
  c.baseline.experiment = "small";
  c.baseline.provenance = nlohmann::json{{"cpu", "this cpu"}};
  const json good = json::parse(to_json_text(c.baseline));
  const std::pair<const char*, std::function<void(json&)>> damages[] = {
      {"/schema: is 2", [](json& b) { b["schema"] = 2; }},
      {"/provenance/cpu: is missing", [](json& b) { b["provenance"].erase("cpu"); }},
      {"/rows: is missing", [](json& b) { b.erase("rows"); }},
      {"/rows: holds no rows", [](json& b) { b["rows"] = json::array(); }},
      {"/rows/1/metrics: has no value",
       [](json& b) {
         for (json& value : b["rows"][1]["metrics"]) value = nullptr;
       }},
      {"/checksum: is not that of the content: it has no checksum",
       [](json& b) { b.erase("checksum"); }},
      {"/checksum: is not that of the content", [](json& b) { b["rows"].erase(1); }},
      {"/checksum: is not that of the content",
       [](json& b) { b["rows"][1]["metrics"]["AR"] = 1.3; }},
      {"/networks: is missing", [](json& b) { b.erase("networks"); }},
      {"/trainings: must be a list of names", [](json& b) { b["trainings"] = {1}; }},
      {"/rows/1/frames: ", [](json& b) { b["rows"][1]["frames"] = -1; }},
      {"/rows/1/metrics/AR: ", [](json& b) { b["rows"][1]["metrics"]["AR"] = "1.2"; }},
      {"/rows/1/metrics/PE: is missing", [](json& b) { b["rows"][1]["metrics"].erase("PE"); }},
      {"/rows/1/metrics/colour: ", [](json& b) { b["rows"][1]["metrics"]["colour"] = 1; }},
      {"/rows/3/metrics/AR: ", [](json& b) { b["rows"][3]["metrics"]["AR"].erase(0); }},
      {"/rows/3/seeds: ", [](json& b) { b["rows"][3]["seeds"] = {1}; }},
      {"/rows/2/tolerance/class: ", [](json& b) { b["rows"][2]["tolerance"]["class"] = "soft"; }},
      {"/rows/2/tolerance/relative: ", [](json& b) { b["rows"][2]["tolerance"]["relative"] = 2; }},
      {"/rows/2/times/latency: ", [](json& b) { b["rows"][2]["times"]["latency"] = 0; }},
      {"/rows/0/colour: ", [](json& b) { b["rows"][0]["colour"] = "red"; }},
  };
  for (const auto& [place, damage] : damages) {
    SCOPED_TRACE(place);
    json bad = good;
    damage(bad);
    testing::write_text(folder / "bad.json", bad.dump());
    try {
      read_baseline(folder / "bad.json");
      FAIL() << "was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("bad.json: " + std::string(place)),
                std::string::npos)
          << error.what();
    }
  }
}

}  // namespace
}  // namespace ertbench
