// Cross-validation on measured frames: which rows are learned from, and what is made of what was
// found.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/study_spec.h"
#include "bench/folds/presses.h"
#include "core/json.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// The presses that lie in the project, in four folds.
Folds skin_folds() {
  const json sensor = {{"shape", "disc"}, {"diameter_mm", 171}, {"drive", "opposite"}};
  const json set = {
      {"file", "skin_presses.h5"},
      {"contact",
       {{"conductivity_ratio", 0.4}, {"strength", {{"dataset", "/depth_mm"}, {"full", 20}}}}}};
  Folds folds;
  folds.base = dataset_spec_from_json(JsonObject(set, "test", ""),
                                      sensor_from_json(JsonObject(sensor, "test", "")), "train",
                                      ERTBENCH_SOURCE_DIR "/experiments/data");
  folds.count = 4;
  folds.presses = {30, 300};
  return folds;
}

std::set<std::uint64_t> rows_of(const DatasetSpec& spec) {
  const std::vector<std::uint64_t> rows = spec.measured()->rows();
  return {rows.begin(), rows.end()};
}

TEST(Folds, LearnFromNoPressThatIsHeldOut) {
  const Folds folds = skin_folds();
  std::set<std::uint64_t> held;
  for (int fold = 0; fold < folds.count; ++fold) {
    const std::set<std::uint64_t> test = rows_of(folds.test(fold));
    held.insert(test.begin(), test.end());
    std::set<std::uint64_t> before;
    for (const std::uint64_t number : folds.presses) {
      std::set<std::uint64_t> learned = rows_of(folds.training(fold, number));
      const std::set<std::uint64_t> chosen_on = rows_of(folds.validation_set(fold, number));
      EXPECT_EQ(learned.size() + chosen_on.size(), number);
      learned.insert(chosen_on.begin(), chosen_on.end());
      EXPECT_EQ(learned.size(), number);
      for (const std::uint64_t row : test) EXPECT_EQ(learned.count(row), 0u);
      for (const std::uint64_t row : before) EXPECT_EQ(learned.count(row), 1u);
      before = learned;
    }
  }
  EXPECT_EQ(held.size(), 400u);
}

TEST(Presses, AreDistancesAndAMissedOneIsInTheMiddle) {
  Folds folds = skin_folds();
  folds.presses = {300};
  FoldsOutcome outcome{"solver", {}, ""};
  for (int fold = 0; fold < folds.count; ++fold) {
    FoldRun run{300, "", 1, {}};
    // Found 5 mm away, of the depth 10 mm and read as 11 mm; and not found, 40 mm from the middle.
    run.held_out.push_back({{10, 20}, 0.3, Eigen::Vector2d(13, 24), 0.33});
    run.held_out.push_back({{0, -40}, 0.6, std::nullopt, 0});
    outcome.folds.push_back({run});
  }
  const json level = presses_study(folds, {outcome}).numbers["solvers"]["solver"]["after"]["300"];
  EXPECT_EQ(level["presses"], 8);
  EXPECT_EQ(level["missed"], 4);
  EXPECT_NEAR(level["mean_mm"]["value"], 22.5, 1e-9);
  EXPECT_NEAR(level["worst_mm"], 40, 1e-9);
  EXPECT_NEAR(level["strength_error"]["value"], (1 + 20) / 2.0, 1e-9);
  ASSERT_EQ(level["by_strength"].size(), 2u);
  EXPECT_NEAR(level["by_strength"][0]["mean_mm"]["value"], 5, 1e-9);
  EXPECT_NEAR(level["by_strength"][1]["mean_mm"]["value"], 40, 1e-9);
  EXPECT_EQ(level["fold_means_mm"].size(), 4u);
}

TEST(FoldRecords, ComeBackAsTheyWere) {
  FoldRun run{25, "why", 0.5, {}};
  run.held_out.push_back({{1, 2}, 0.3, Eigen::Vector2d(3, 4), 0.2});
  run.held_out.push_back({{5, 6}, 0.4, std::nullopt, 0});
  const FoldRecord back = fold_record_from_json(to_json(FoldRecord{run}));
  ASSERT_EQ(back.size(), 1u);
  EXPECT_EQ(back[0].presses, 25u);
  EXPECT_EQ(back[0].message, "why");
  EXPECT_EQ(back[0].fit_s, 0.5);
  EXPECT_EQ(back[0].held_out, run.held_out);
}

}  // namespace
}  // namespace ertbench
