// How far the times of one solver lie from each other when nothing changed, and whether a slow-down
// of 1.5 times stands out: on rounds that were recorded, not by this test's own clock.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/check/check.h"
#include "bench/record/measurement_records.h"
#include "core/json.h"

namespace ertbench {
namespace {

constexpr double slow_down = 1.5;

/// One run's row of a solver: in each round the median and the fastest frame and the calibration,
/// µs; the solver takes `factor` times as long.
ResultRow timed_row(const std::string& label, const nlohmann::json& rounds, double factor) {
  ResultRow row;
  row.label = label;
  row.dataset = "test";
  row.latency_us.emplace();
  for (const auto& round : rounds) {
    row.latency_us->relative_of_rounds.push_back(relative_latency(
        factor * round[0].get<double>(), factor * round[1].get<double>(), round[2].get<double>()));
  }
  row.calibration_us = 1;
  row.frames_per_s = 1e6;
  return row;
}

Verdict verdict_on(const ResultRow& before, const ResultRow& now) {
  Baseline baseline;
  baseline.cpu = "this cpu";
  BaselineRow& row = baseline.rows.emplace_back();
  row.label = before.label;
  row.dataset = before.dataset;
  row.times = relative_times(before);
  for (const CheckLine& line : compare(baseline, std::vector{now}, {"this cpu"})) {
    if (line.quantity == "latency / calibration") return line.verdict;
  }
  throw std::runtime_error("no line of the latency");
}

// tests/data/latency_rounds.json: 20 repetitions of the three classical solvers in 5 rounds of 132
// frames each, on two cores that ten other processes shared. Each repetition stands once for the
// baseline against all others.
TEST(CheckLatency, ASlowDownStandsOutOfTheNoiseOfABusyMachine) {
  const nlohmann::json repetitions =
      read_json_file(std::filesystem::path(ERTBENCH_TEST_DATA) / "latency_rounds.json")
          .at("repetitions");
  ASSERT_EQ(repetitions.size(), 20u);
  for (const char* solver : {"one-step-gn", "tsvd", "pdipm"}) {
    for (std::size_t i = 0; i < repetitions.size(); ++i) {
      for (std::size_t j = 0; j < repetitions.size(); ++j) {
        if (i == j) continue;
        SCOPED_TRACE(std::string(solver) + ", baseline " + std::to_string(i) + ", now " +
                     std::to_string(j));
        const ResultRow before = timed_row(solver, repetitions[i].at(solver), 1);
        EXPECT_EQ(verdict_on(before, timed_row(solver, repetitions[j].at(solver), 1)), Verdict::ok);
        EXPECT_EQ(verdict_on(before, timed_row(solver, repetitions[j].at(solver), slow_down)),
                  Verdict::slower);
      }
    }
  }
}

TEST(CheckLatency, OfLongFramesTheFastestCounts) {
  EXPECT_DOUBLE_EQ(relative_latency(10, 8, 4), 2.5);
  EXPECT_DOUBLE_EQ(relative_latency(9000, 5000, 4), 1250);
}

}  // namespace
}  // namespace ertbench
