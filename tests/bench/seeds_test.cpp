#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/run/rows.h"
#include "bench/score/metrics.h"

namespace ertbench {
namespace {

/// Frames whose AR are `values`; nothing else is defined.
ScoredSet set_of(const std::vector<std::optional<double>>& values, double fit_s,
                 const std::string& parameters) {
  ScoredSet set;
  for (const auto& value : values) {
    set.frames.emplace_back()[Metric::AR] = value;
    set.statuses.push_back(value ? FrameStatus::ok : FrameStatus::undefined);
  }
  set.row.label = "net";
  set.row.type = "toy";
  set.row.dataset = "test";
  set.row.frames = static_cast<int>(values.size());
  set.row.metrics = summarise(set.frames);
  set.row.fit_s = fit_s;
  set.row.parameters = nlohmann::json::parse(parameters);
  return set;
}

TEST(Seeds, MeanOfMeansAndIntervalOfTheFramesMeans) {
  const ScoredSet one = set_of({1.0, 2.0, 6.0}, 10, R"({"seed":1,"width":8,"best":3})");
  const ScoredSet two = set_of({3.0, 2.0, 4.0}, 20, R"({"seed":2,"width":8,"best":5})");
  const ScoredSet three = set_of({2.0, 5.0, 5.0}, 60, R"({"seed":3,"width":8})");
  const std::vector<SeedResult> results = {{1, &one}, {2, &two}, {3, &three}};
  const ResultRow row = combine_seeds(results);
  const MetricSummary& ar = row.metrics[Metric::AR];
  EXPECT_DOUBLE_EQ(ar.mean.value(), (3.0 + 3.0 + 4.0) / 3);
  const std::vector<std::optional<double>> frame_means = {2.0, 3.0, 5.0};
  EXPECT_EQ(ar.ci95, summarise(frame_means, "AR").ci95);
  EXPECT_DOUBLE_EQ(ar.median.value(), 3);
  EXPECT_EQ(ar.count, 3);
  ASSERT_TRUE(row.seeds);
  EXPECT_EQ(row.seeds->values, (std::vector{1, 2, 3}));
  EXPECT_EQ(row.seeds->means[Metric::AR], (std::vector<std::optional<double>>{3.0, 3.0, 4.0}));
  EXPECT_NEAR(row.seeds->deviation[Metric::AR].value(), std::sqrt(1.0 / 3), 1e-12);  // of 3, 3, 4
  EXPECT_FALSE(row.seeds->deviation[Metric::PE]);
  EXPECT_DOUBLE_EQ(row.fit_s.value(), 20);  // of 10, 20 and 60
  EXPECT_EQ(row.parameters->at("best"), 3);
  EXPECT_EQ(*row.seeds->parameters,
            nlohmann::json::parse(R"([{"seed":1,"best":3},{"seed":2,"best":5},{"seed":3}])"));
}

TEST(Seeds, AFrameThatIsUndefinedForOneIsUndefined) {
  const ScoredSet one = set_of({1.0, std::nullopt, 3.0, std::nullopt}, 1, "{}");
  const ScoredSet two = set_of({std::nullopt, std::nullopt, 5.0, 7.0}, 1, "{}");
  const std::vector<SeedResult> results = {{1, &one}, {2, &two}};
  const ResultRow row = combine_seeds(results);
  const MetricSummary& ar = row.metrics[Metric::AR];
  EXPECT_EQ(ar.count, 1);
  EXPECT_EQ(ar.undefined, 3);
  EXPECT_EQ(row.undefined_frames, 3);
  EXPECT_DOUBLE_EQ(ar.mean.value(), (2.0 + 6.0) / 2);  // each seed's mean over its own frames
  EXPECT_EQ(ar.ci95, (Interval{4, 4}));
}

TEST(Seeds, OneSeedIsItsOwnRowWithoutADeviation) {
  const ScoredSet one = set_of({1.0, 2.0, 6.0}, 10, R"({"seed":7})");
  const std::vector<SeedResult> results = {{7, &one}};
  const ResultRow row = combine_seeds(results);
  EXPECT_EQ(row.metrics[Metric::AR], one.row.metrics[Metric::AR]);
  EXPECT_EQ(row.seeds->values, std::vector{7});
  EXPECT_FALSE(row.seeds->deviation[Metric::AR]);
}

/// An experiment of one label with two seeds.
class Rows : public ::testing::Test {
 protected:
  Rows() {
    tests_.emplace_back().name = "test";
    entries_.resize(2);
    for (int seed : {1, 2}) {
      SolverEntry& entry = entries_[static_cast<std::size_t>(seed - 1)];
      entry.label = "net";
      entry.type = "toy";
      entry.spec = JsonValue::object();
      entry.seed = seed;
      ScoredTrial& outcome = outcomes_.emplace_back();
      outcome.entry = &entry;
      outcome.accuracy.emplace().sets = {set_of({double(seed)}, 1, "{}")};
    }
  }
  void fail(std::size_t trial, const Failure& failure) {
    outcomes_[trial].accuracy.reset();
    outcomes_[trial].failure = failure;
  }
  void report(std::size_t trial, const std::string& status, const std::string& message) {
    outcomes_[trial].accuracy->sets[0].row.status = status;
    outcomes_[trial].accuracy->sets[0].row.message = message;
  }
  ResultRow row() const { return rows_of(tests_, outcomes_).at(0); }

  std::vector<DatasetSpec> tests_;
  std::vector<SolverEntry> entries_;
  std::vector<ScoredTrial> outcomes_;
};

TEST_F(Rows, AllWell) {
  EXPECT_TRUE(row().ok());
  EXPECT_EQ(row().message, "");
  EXPECT_DOUBLE_EQ(row().metrics[Metric::AR].mean.value(), 1.5);
}

TEST_F(Rows, NumbersAreOfTheSeedsThatHaveAny) {
  fail(0, {"crashed", "Aborted"});
  EXPECT_EQ(row().status, "crashed");
  EXPECT_EQ(row().message, "seed 1: Aborted; the numbers are of the other seed");
  EXPECT_DOUBLE_EQ(row().metrics[Metric::AR].mean.value(), 2);
  EXPECT_EQ(row().seeds->values, std::vector{2});
}

TEST_F(Rows, AllFailed) {
  fail(0, {"failed", "no memory"});
  fail(1, {"failed", "no memory"});
  EXPECT_EQ(row().status, "failed");
  EXPECT_EQ(row().message, "no memory");
  EXPECT_FALSE(row().metrics[Metric::AR].mean);
  EXPECT_FALSE(row().seeds);
  fail(1, {"timed out", "after 8.0 s"});
  EXPECT_EQ(row().message, "seed 1: no memory; seed 2: timed out: after 8.0 s");
}

TEST_F(Rows, WhatAFitReportsKeepsItsNumbers) {
  report(1, "diverged", "loss 1e9");
  EXPECT_EQ(row().status, "diverged");
  EXPECT_EQ(row().message, "seed 2: loss 1e9");
  EXPECT_DOUBLE_EQ(row().metrics[Metric::AR].mean.value(), 1.5);
  fail(0, {"failed", "no memory"});
  EXPECT_EQ(row().status, "failed");
  EXPECT_EQ(row().message,
            "seed 1: no memory; seed 2: diverged: loss 1e9; the numbers are of the other seed");
}

}  // namespace
}  // namespace ertbench
