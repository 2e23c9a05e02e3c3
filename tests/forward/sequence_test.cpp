#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/files.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::Vector2d;

Sensor skin_sensor(double prompt_share = 0.8) {
  Sensor sensor;
  sensor.skin = Skin{};
  sensor.skin->foam.prompt_share = prompt_share;
  return sensor;
}

DatasetSpec spec_of(const char* text, const Sensor& sensor = skin_sensor()) {
  const auto json = nlohmann::json::parse(text);
  return dataset_spec_from_json(JsonObject(json, "test", ""), sensor, "test");
}

/// The frames of a finger that passes the sheet's (7, -3) mm at 0.5 s, evenly along x.
std::vector<SequenceFrames::Frame> passing(double speed_mm_s, DatasetSpec& spec) {
  // A character's path is all that there is of moving ones; its first stroke is taken elsewhere.
  std::vector<SequenceFrames::Frame> frames(1);
  const FrameTiming timing{125, 0.0005};
  Indenter disc;
  const auto touch_at = [&](double time) {
    return std::vector{Touch{disc, Vector2d(7 + speed_mm_s * (time - 0.5), -3), 5}};
  };
  for (int drive = 0; drive < 16; ++drive) {
    const double time = 0.5 + (drive - 7.5) * timing.drive_time_s;
    frames[0].drives.push_back(still_scene(spec.sensor, touch_at(time)));
  }
  frames[0].truth = still_scene(spec.sensor, touch_at(0.5));
  return frames;
}

constexpr const char* kWriting =
    R"({"grid": 24, "snr_db": 50, "snr_basis": "absolute",
        "scenes": {"sequence": "write", "characters": "L7", "speed_mm_s": 400}})";

TEST(Sequences, AStillOneEqualsTheStillScene) {
  // Pressed for so long that the foam has relaxed: its frames are those of the scene at rest.
  const DatasetSpec spec = spec_of(
      R"({"grid": 24, "snr_db": null, "scenes": {"sequence": "press", "areas": 1, "forces_N": [4],
          "hold_s": 30, "frame_rate": 1}})");
  const SceneModel model(spec.sensor, spec.model);
  const DatasetBlock block = generate_block(spec, model, 0, spec.count);
  const Scene still = still_scene(spec.sensor, std::vector{Touch{Indenter{}, {0, 0}, 4}});
  Frames expected(1, 208);
  RowMajorMatrix effort(1, 0);
  const std::uint64_t zero = 0;
  model.solve(spec, {&still, 1}, {&zero, 1}, expected, effort);
  const RowVectorXd last = block.clean_voltages.row(block.clean_voltages.rows() - 1);
  EXPECT_LT((last - expected.row(0)).norm(), 1e-13 * expected.norm());
  EXPECT_GT((block.clean_voltages.row(0) - expected.row(0)).norm(), 1e-6 * expected.norm());
}

TEST(Sequences, MovingSlowlyConvergesLinearlyInSpeed) {
  DatasetSpec spec = spec_of(kWriting);
  const SceneModel model(spec.sensor, spec.model);
  std::vector<double> errors;
  for (const double speed : {16.0, 8.0, 4.0}) {
    const auto frames = passing(speed, spec);
    Frames moving(1, 208);
    solve_drives(spec, model, frames, {0}, 0, moving);
    Frames still(1, 208);
    RowMajorMatrix effort(1, 0);
    const std::uint64_t zero = 0;
    model.solve(spec, {&frames[0].truth, 1}, {&zero, 1}, still, effort);
    errors.push_back((moving - still).norm());
  }
  EXPECT_NEAR(errors[0] / errors[1], 2, 0.1);
  EXPECT_NEAR(errors[1] / errors[2], 2, 0.1);
}

TEST(Sequences, TheParabolaKeepsItsTolerance) {
  DatasetSpec spec = spec_of(kWriting);
  const SceneModel model(spec.sensor, spec.model);
  for (const double speed : {20.0, 100.0, 400.0, 2000.0}) {
    const auto frames = passing(speed, spec);
    Frames exact(1, 208);
    Frames quick(1, 208);
    solve_drives(spec, model, frames, {0}, 0, exact);
    solve_drives(spec, model, frames, {0}, drive_tolerance, quick);
    EXPECT_LT((exact - quick).norm(),
              drive_tolerance * noise_norm(spec.noise, model.reference_voltages(), exact.row(0)))
        << speed;
  }
}

TEST(Sequences, BlocksMayBeginAnywhere) {
  const DatasetSpec spec = spec_of(kWriting);
  const SceneModel model(spec.sensor, spec.model);
  const DatasetBlock whole = generate_block(spec, model, 0, spec.count);
  for (const std::uint64_t first : {std::uint64_t{30}, spec.count - 20}) {
    const DatasetBlock part = generate_block(spec, model, first, 20, 2);
    const auto row = static_cast<Eigen::Index>(first);
    // Skipped frames are gone through in other steps.
    EXPECT_LT((part.clean_voltages - whole.clean_voltages.middleRows(row, 20)).norm(),
              1e-4 * (whole.clean_voltages.rowwise() - model.reference_voltages().transpose())
                         .middleRows(row, 20)
                         .norm());
    EXPECT_EQ(part.moments, whole.moments.middleRows(row, 20));
    EXPECT_EQ(part.forces.array().isNaN().count(),
              whole.forces.middleRows(row, 20).array().isNaN().count());
  }
}

TEST(Sequences, FilesTellTimeSequenceAndForce) {
  const TemporaryFolder folder("sequences");
  const DatasetSpec spec = spec_of(kWriting);
  const std::filesystem::path file = folder.path() / "set.h5";
  generate_dataset(spec, file);
  const DatasetFile set(file);
  ASSERT_EQ(set.size(), spec.count);
  const Eigen::VectorXd sequences = set.sequences(0, set.size());
  const Eigen::VectorXd times = set.times(0, set.size());
  EXPECT_EQ(sequences[0], 0);
  EXPECT_EQ(sequences[sequences.size() - 1], 1);
  // The middle of a frame of 16 drives of 0.5 ms that ends after 8 ms.
  EXPECT_NEAR(times[0], 0.004, 1e-12);
  EXPECT_NEAR(times[1] - times[0], 1 / 125.0, 1e-12);
  const std::vector<Scene> scenes = set.scenes(0, set.size());
  ASSERT_EQ(scenes[5].contacts.size(), 1u);
  EXPECT_EQ(scenes[5].contacts[0].force_N, 2);
  EXPECT_EQ(set.spec().count, spec.count);
}

TEST(Sequences, CountIsThatOfTheFrames) {
  EXPECT_THROW(spec_of(R"({"count": 7, "grid": 24, "snr_db": null,
                           "scenes": {"sequence": "press", "hold_s": 0.5, "frame_rate": 2}})"),
               std::exception);
  const DatasetSpec spec = spec_of(R"({"grid": 24, "snr_db": null,
      "scenes": {"sequence": "press", "hold_s": 0.5, "frame_rate": 2}})");
  EXPECT_EQ(spec.count, 25u * 19u);  // up to 10 N and down to 1 N again, a frame each
}

TEST(Touches, FramesOfASceneShareItAndNotTheNoise) {
  const DatasetSpec spec = spec_of(
      R"({"grid": 24, "snr_db": 50, "snr_basis": "absolute", "scenes": {"touches": 1,
          "indenters": [{"type": "flat"}], "force_N": 5, "places": {"grid": [3, 3]}, "draws": 4}})");
  EXPECT_EQ(spec.count, 36u);
  const SceneModel model(spec.sensor, spec.model);
  const DatasetBlock block = generate_block(spec, model, 0, spec.count);
  EXPECT_EQ(block.clean_voltages.row(4), block.clean_voltages.row(7));
  EXPECT_NE(block.voltages.row(4), block.voltages.row(7));
  EXPECT_NE(block.clean_voltages.row(3), block.clean_voltages.row(4));
  // The second place is one column to the right of the first, of 200 / 3 mm.
  EXPECT_NEAR(block.truths[4].contacts[0].centre.x() - block.truths[0].contacts[0].centre.x(),
              2.0 / 3, 1e-12);
}

TEST(Faults, DriftAndBatteryGrowWithTime) {
  Faults faults;
  faults.background_drift = 0.001;
  EXPECT_NEAR(drift_factor(faults, 600), 1.01, 1e-12);
  faults.battery_sag = 0.01;
  RandomStream random(1, 2, 3, Purpose::battery);
  EXPECT_NEAR(battery_factor(faults, 1800, random), 0.995, 1e-12);
  faults.current_measured = true;
  EXPECT_NEAR(battery_factor(faults, 1800, random), 1, 1e-12);
  faults.adc_bits = 12;
  EXPECT_NEAR(battery_factor(faults, 1800, random), 1, 2.5 / 4096);
}

}  // namespace
}  // namespace ertbench
