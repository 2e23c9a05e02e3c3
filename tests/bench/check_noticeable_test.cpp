// What a check notices: the limits that the stored baseline keeps, mutations of its rows, and how
// often sound networks are called worse.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bench/check/check.h"
#include "bench/experiment/experiment_json.h"
#include "bench/table/table.h"
#include "core/random.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

const std::filesystem::path source_folder = ERTBENCH_SOURCE_DIR;

/// The baseline of the quick experiment, as it is stored, and a check's rows that repeat it.
struct StoredCheck {
  StoredCheck() {
    const ExperimentJson quick = read_experiment_json(source_folder / "experiments/quick.json");
    trainings = quick.content->at("check").at("seeds");
    for (const BaselineRow& row : baseline.rows) rows.push_back(repeated(row));
  }

  ResultRow repeated(const BaselineRow& row) const {
    ResultRow out;
    out.label = row.label;
    out.type = row.label;
    out.dataset = row.dataset;
    out.status = row.status;
    out.frames = row.frames;
    out.undefined_frames = row.undefined_frames;
    out.frames_not_converged = row.frames_not_converged;
    if (!row.seeds.empty()) out.seeds.emplace();
    for (const Metric metric : kMetrics) {
      if (!row.metrics[metric].empty()) shift(out, row, metric, 0);
    }
    if (row.times) {
      out.latency_us = LatencySummary{row.times->latency, 0, 0};
      out.frames_per_s = 1e6 / row.times->batch_frame;
      out.calibration_us = 1;
    }
    return out;
  }

  /// The row's mean of one metric is the stored one and `change`, and so are those of today's
  /// trainings, of which the first stored ones are taken.
  void shift(ResultRow& out, const BaselineRow& row, Metric metric, double change) const {
    const std::vector<double>& values = row.metrics[metric];
    out.metrics[metric].mean = centre_of(values) + change;
    if (!out.seeds) return;
    std::vector<std::optional<double>>& means = out.seeds->means[metric];
    means.clear();
    for (int i = 0; i < trainings; ++i)
      means.push_back(values[static_cast<std::size_t>(i)] + change);
  }

  std::vector<CheckLine> lines() const { return compare(baseline, rows, {baseline.cpu, sensor}); }

  const Sensor sensor = {};
  const Baseline baseline = read_baseline(source_folder / "results/baselines/quick.json");
  int trainings = 1;
  std::vector<ResultRow> rows;
};

std::vector<std::string> worse_lines(const std::vector<CheckLine>& lines) {
  std::vector<std::string> out;
  for (const CheckLine& line : lines) {
    if (is_regression(line.verdict)) out.push_back(line.row + " " + line.quantity);
  }
  return out;
}

TEST(CheckNotices, TheStoredBaselineKeepsTheLimits) {
  const StoredCheck check;
  const auto all = noticeable_worsenings(check.baseline, check.sensor, check.trainings);
  int limited = 0;
  for (const Noticeable& one : all) {
    SCOPED_TRACE(one.row + " " + name_of(one.metric) + ": " + text_of(one));
    const bool has_limit = one.part_of_limit().has_value();
    limited += has_limit;
    if (one.type == ToleranceClass::seeds && has_limit) {
      EXPECT_LE(*one.part_of_limit(), 1);
    }
    // Linear images: the rounding of the mean, relative or in the metric's own unit; metrics of a
    // threshold let a pixel of one frame change sides besides (allowed_change).
    if (one.type == ToleranceClass::linear && entry_of(one.metric).threshold == Threshold::none) {
      EXPECT_LE(one.amount, 1e-8 * std::max(1.0, std::abs(one.centre)));
    }
  }
  // Four of seven solvers, of the truth AR and PE (its errors are 0), all but PE of no-contact.
  EXPECT_EQ(limited, 4 * 7 + 2 + 3);
  EXPECT_TRUE(beyond_limits(all).empty());
  EXPECT_TRUE(worse_lines(check.lines()).empty());
}

TEST(CheckNotices, EveryWorseningBeyondTheAmountAndNoneOfAQuarterOfIt) {
  StoredCheck check;
  const auto all = noticeable_worsenings(check.baseline, check.sensor, check.trainings);
  ASSERT_FALSE(all.empty());
  const PerMetric<MetricSummary> truth = check.rows.front().metrics;
  ASSERT_EQ(check.rows.front().type, "truth");
  for (const Noticeable& one : all) {
    SCOPED_TRACE(one.row + " " + name_of(one.metric) + ": " + text_of(one));
    const auto row = std::find_if(check.rows.begin(), check.rows.end(), [&](const ResultRow& r) {
      return r.label == one.row && r.dataset == one.dataset;
    });
    ASSERT_NE(row, check.rows.end());
    const auto distance = [&](double change) {
      return distance_from_ideal(one.metric, one.centre + change, truth[one.metric].mean);
    };
    const double away = distance(one.amount) >= distance(-one.amount) ? one.amount : -one.amount;
    const auto shift = [&](double change) {
      check.shift(*row, *check.baseline.find(*row), one.metric, change);
    };
    shift(1.02 * away);
    EXPECT_EQ(worse_lines(check.lines()),
              std::vector<std::string>{one.row + " " + name_of(one.metric)});
    for (const double sign : {1.0, -1.0}) {
      shift(0.25 * sign * one.amount);
      EXPECT_EQ(worse_lines(check.lines()), std::vector<std::string>{});
    }
    shift(0);
  }
}

/// By tables of Student's t: of 12 trainings and 8 in a check the interval reaches 4.437 * 0.4564
/// deviations, of 24 3.768 * 0.4082, of 25 3.745 * 0.4062, and a part of 1.32 of the limit asks for
/// a width of no more than 1.534.
TEST(CheckNotices, ACoarseBaselineIsToldHowManySeedsWouldDo) {
  const Noticeable coarse{"dcnn", "test", Metric::PE, ToleranceClass::seeds, 0.06, 0.33 * 0.06};
  const Noticeable fine{"dcnn", "test", Metric::RIE, ToleranceClass::seeds, 0.06, 0.01 * 0.06};
  EXPECT_EQ(seeds_that_would_do(std::vector{fine, coarse}, 12, 8, 100), 25);
  EXPECT_EQ(seeds_that_would_do(std::vector{coarse}, 12, 8, 24), std::nullopt);
  EXPECT_EQ(seeds_that_would_do(std::vector{fine}, 12, 8, 100), 12);
}

TEST(CheckNotices, TheWeakestRowIsNamedAndTheTableHasAllOfThem) {
  const StoredCheck check;
  const auto all = noticeable_worsenings(check.baseline, check.sensor, check.trainings);
  EXPECT_EQ(weakest_text({}), "");
  std::vector<Noticeable> two = {
      {"a", "test", Metric::AR, ToleranceClass::seeds, 1.1, 0.015},
      {"b", "test", Metric::relative_error, ToleranceClass::seeds, 0.5, 0.04},
      {"b", "test", Metric::SSIM, ToleranceClass::seeds, 0.5, 0.4}};
  EXPECT_EQ(weakest_text(two), "weakest: b relative_error, noticed from 0.04 (8 %)");
  EXPECT_TRUE(beyond_limits(two).empty());
  two.front().amount = 0.031;
  ASSERT_EQ(beyond_limits(two).size(), 1u);
  EXPECT_EQ(beyond_limits(two).front().row, "a");
  EXPECT_EQ(weakest_text(two), "weakest: a AR, noticed from 0.031");
  const std::string table = terminal_of(noticeable_table(all));
  for (const BaselineRow& row : check.baseline.rows) {
    EXPECT_NE(table.find("\n" + row.label + " "), std::string::npos) << table;
  }
}

// With 99.9 % a sound mean lies beyond the interval in 0.1 % of the checks, half of them on the
// side of the worse. The margin is nine standard deviations of the count, 20 in 40000.
TEST(CheckNotices, GaussianSeedsAreCalledWorseAsRarelyAsTheIntervalSays) {
  constexpr int checks = 40000;
  const StoredCheck stored;
  const int now = stored.trainings;
  const int before = static_cast<int>(stored.baseline.rows.back().seeds.size());
  const Tolerance tolerance{ToleranceClass::seeds, 1e-4};
  RandomStream random(1, key_of("false alarms"), 0, Purpose::training);
  RecordProperty("seed", 1);
  const auto values = [&](int count) {
    std::vector<double> out(static_cast<std::size_t>(count));
    for (double& value : out) value = 1 + 0.02 * random.normal();
    return out;
  };
  const double quantile = student_t_quantile(0.9995, before - 1);
  int worse = 0;
  int unnoticed = 0;
  for (int i = 0; i < checks; ++i) {
    const std::vector<double> old = values(before);
    const double allowed =
        allowed_change(tolerance, {Metric::relative_error, old, 200, Sensor{}, std::nullopt}, now);
    const double change = mean(values(now)) - mean(old);
    // The standard deviation of the change is sqrt(1/m + 1/n) of that of the seeds.
    const double true_amount = 0.02 * std::sqrt(1.0 / now + 1.0 / before) * (quantile + 1.28);
    worse += change > allowed;
    unnoticed += change + true_amount <= allowed;
  }
  EXPECT_LT(worse, 60);
  EXPECT_GT(worse, 2);
  EXPECT_LT(unnoticed, 0.2 * checks);  // one in ten, were the deviation known
}

// A third of the stored seeds are taken for today's, the others for the baseline: real means are
// not quite Gaussian.
TEST(CheckNotices, SeedsLeftOutOfTheStoredBaselineAreNotCalledWorse) {
  constexpr int splits = 400;
  const StoredCheck stored;
  RandomStream random(2, key_of("left out"), 0, Purpose::training);
  RecordProperty("seed", 2);
  int compared = 0;
  int worse = 0;
  for (const BaselineRow& row : stored.baseline.rows) {
    if (row.seeds.empty()) continue;
    for (const Metric metric : stored.baseline.metrics) {
      std::vector<double> values = row.metrics[metric];
      const std::size_t now = values.size() / 3;
      ASSERT_GT(values.size(), now + least_seeds);
      for (int split = 0; split < splits; ++split) {
        for (std::size_t i = 0; i < now; ++i) {  // Fisher-Yates, as far as it is needed
          const int last = static_cast<int>(values.size()) - 1;
          std::swap(values[i],
                    values[static_cast<std::size_t>(random.integer(static_cast<int>(i), last))]);
        }
        const std::span<const double> all(values);
        const auto old = all.subspan(now);
        const double today = mean(all.first(now));
        const double before = mean(old);
        const auto& truth = stored.rows.front().metrics[metric].mean;
        ++compared;
        const std::vector<std::optional<double>> seeds(all.begin(), old.begin());
        worse +=
            is_beyond(row.tolerance, {metric, old, row.frames, stored.sensor, {}},
                      {today, seeds}) &&
            distance_from_ideal(metric, today, truth) >= distance_from_ideal(metric, before, truth);
      }
    }
  }
  // 0.05 % for Gaussian seeds, and the splits of a row are not independent of each other.
  EXPECT_LT(worse, 0.002 * compared) << compared;
}

}  // namespace
}  // namespace ertbench
