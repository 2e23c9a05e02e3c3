// Cross-validation on measured frames: which rows are learned from, and what is made of what was
// found.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/study_spec.h"
#include "bench/folds/presses.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/data/measured_file.h"

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
  folds.skins = {dataset_spec_from_json(JsonObject(set, "test", ""),
                                        sensor_from_json(JsonObject(sensor, "test", "")), "train",
                                        ERTBENCH_SOURCE_DIR "/experiments/data")};
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

/// A skin of `channels` channels whose presses lie around (70, 30) mm, 20 mm off it at most.
void write_skin(const std::filesystem::path& path, int presses, int channels) {
  RowMajorMatrix changes(presses, channels);
  RowMajorMatrix places(presses, 2);
  for (int i = 0; i < presses; ++i) {
    const double turn = 2.4 * i;
    places.row(i) << 70 + 20 * std::cos(turn), 30 + 20 * std::sin(turn);
    for (int c = 0; c < channels; ++c) changes(i, c) = std::sin(turn + c);
  }
  changes.col(3).setConstant(std::nan(""));
  changes(1, 2) = std::nan("");
  Hdf5File file = Hdf5File::create(path);
  file.write_matrix("/changes", changes);
  file.write_matrix("/positions_mm", places);
  file.close();
}

TEST(Skins, AreReadAroundTheMiddleOfTheirPresses) {
  const TemporaryFolder folder;
  write_skin(folder / "skin.h5", 40, 37);
  const Sensor sensor = sensor_of_presses(folder / "skin.h5");
  EXPECT_EQ(sensor.channels(), 37);
  EXPECT_NEAR(sensor.sheet->radius() * sensor.sheet->unit_mm(), 1.1 * 20, 0.3);
  const json set = {{"file", (folder / "skin.h5").string()}};
  const DatasetSpec spec =
      dataset_spec_from_json(JsonObject(set, "test", ""), sensor, "train", std::filesystem::path());
  const MeasuredBlocks blocks(spec);
  const DatasetBlock block = blocks.block(0, 40);
  EXPECT_EQ(block.voltages(1, 2), 0);  // a missing value is no change
  EXPECT_EQ(block.voltages.col(3).norm(), 0);
  EXPECT_NEAR(block.voltages(5, 7), std::sin(2.4 * 5 + 7), 1e-12);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector2d place =
        block.truths[static_cast<std::size_t>(i)].contacts.at(0).centroid();
    EXPECT_NEAR(place.norm() * sensor.sheet->unit_mm(), 20, 0.3);
  }
}

TEST(Skins, RefusalsListWhatTheFileHolds) {
  const TemporaryFolder folder;
  Hdf5File file = Hdf5File::create(folder / "other.h5");
  file.write_matrix("/frames", RowMajorMatrix::Zero(4, 8));
  file.write_matrix("/places", RowMajorMatrix::Zero(4, 2));
  file.close();
  try {
    sensor_of_presses(folder / "other.h5");
    FAIL();
  } catch (const InputError& wrong) {
    EXPECT_NE(std::string(wrong.what()).find("holds frames, places"), std::string::npos)
        << wrong.what();
  }
}

TEST(Skins, HaveFoldsAndErrorsOfTheirOwn) {
  Folds folds = skin_folds();
  folds.skins.push_back(folds.skins[0]);
  MeasuredFrames other = *folds.skins[1].measured();
  other.last = 100;
  other.name = "other.h5";
  folds.skins[1].scenes = other;
  folds.presses = {30, 200};  // more than the second has to learn from
  ASSERT_EQ(folds.total(), 8);
  EXPECT_LT(*rows_of(folds.test(5)).rbegin(), 100u);
  FoldsOutcome outcome{"solver", {}, ""};
  for (int fold = 0; fold < 8; ++fold) {
    const Eigen::Vector2d found(fold < 4 ? 3 : 6, 0);
    FoldRun run{30, "", 1, {}};
    run.held_out.push_back({{0, 0}, 0.3, found, 0.3});
    outcome.folds.push_back({run});
    run.presses = 200;
    if (fold < 4) outcome.folds.back().push_back(run);
  }
  const json numbers = presses_study(folds, {outcome}).numbers;
  const auto mean = [&](const json& of, const char* presses) {
    return of["solvers"]["solver"]["after"][presses]["mean_mm"]["value"].get<double>();
  };
  EXPECT_NEAR(mean(numbers, "30"), 4.5, 1e-9);
  EXPECT_NEAR(mean(numbers["skins"]["skin_presses.h5"], "30"), 3, 1e-9);
  EXPECT_NEAR(mean(numbers["skins"]["other.h5"], "30"), 6, 1e-9);
  EXPECT_FALSE(numbers["skins"]["other.h5"]["solvers"]["solver"]["after"].contains("200"));
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
