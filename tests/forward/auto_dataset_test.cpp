#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

nlohmann::json auto_set(int count) {
  return {{"count", count},          {"seed", 3},
          {"grid", "auto"},          {"snr_db", 50},
          {"snr_basis", "absolute"}, {"scenes", {{"blank_fraction", 0.2}}}};
}

DatasetSpec auto_spec(const nlohmann::json& object, const std::string& name = "test") {
  return dataset_spec_from_json(JsonObject(object, "test", ""), Sensor{}, name);
}

std::string auto_refusal(nlohmann::json object) {
  try {
    auto_spec(object);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(AutoDataset, VoltagesAreThoseOfTheContinuousSheet) {
  const DatasetSpec spec = auto_spec(auto_set(20));
  const SceneModel model(spec.sensor, spec.model);
  const DatasetBlock block = generate_block(spec, model, 0, spec.count);
  const BorderModel borders(spec.sensor);
  const double model_error = std::get<ContinuousSheet>(spec.model).model_error;
  EXPECT_EQ(model.reference_voltages(), borders.reference_voltages());
  for (Eigen::Index i = 0; i < block.effort.rows(); ++i) {
    const Scene scene = spec.scene(static_cast<std::uint64_t>(i));
    const Eigen::VectorXd clean = block.clean_voltages.row(i);
    const double noise = (block.voltages.row(i) - block.clean_voltages.row(i)).norm();
    EXPECT_EQ(block.effort(i, 0) == 0, scene.contacts.empty());
    EXPECT_LE(block.effort(i, 1), model_error * noise);
    const Eigen::VectorXd exact =
        model.reference_voltages() + borders.solve(scene, 1e-2 * noise).change;
    EXPECT_LE((clean - exact).norm(), model_error * noise) << "scene " << i;
  }
}

TEST(AutoDataset, FileHoldsTheEffortAndItsRecipeReadsBack) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "ertbench_auto_dataset_test.h5";
  std::filesystem::remove(file);
  const DatasetSpec spec = auto_spec(auto_set(12));
  generate_dataset(spec, file, {2, {}});
  const RowMajorMatrix effort = Hdf5File::open(file).read_rows("/model_effort", 0, 12);
  EXPECT_GT(effort.col(0).maxCoeff(), 0);
  nlohmann::json recipe = nlohmann::json::parse(DatasetFile(file).recipe());
  EXPECT_EQ(recipe.at("grid"), "auto");
  for (const char* key : {"format_version", "sensor", "name"}) recipe.erase(key);
  EXPECT_EQ(to_json(auto_spec(recipe)), to_json(spec));
  std::filesystem::remove(file);
}

TEST(AutoDataset, SaysOnHowManyScenesThePromiseIsMissed) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "ertbench_missed_promise_test.h5";
  for (const bool out_of_reach : {false, true}) {
    // Corners leave every scene with a contact above 1e-10 of the noise, whatever the points.
    nlohmann::json object = auto_set(6);
    object["scenes"] = {{"blank_fraction", 0.5}, {"shapes", {"rectangle"}}};
    object["faults"] = {{"background_change", 0.5}};
    DatasetSpec spec = auto_spec(object);
    // Below what an experiment may ask for.
    if (out_of_reach) std::get<ContinuousSheet>(spec.model).model_error = 1e-10;
    std::filesystem::remove(file);
    generate_dataset(spec, file, {1, {}});
    std::uint64_t touched = 0;
    for (const Scene& scene : DatasetFile(file).scenes(0, 6)) touched += !scene.contacts.empty();
    ASSERT_GT(touched, 0u);
    ASSERT_LT(touched, 6u);
    const MissedPromise missed = missed_promise(spec, DatasetFile(file));
    EXPECT_EQ(missed.of, 6u);
    EXPECT_EQ(missed.scenes, out_of_reach ? touched : 0);
    const RowMajorMatrix effort = Hdf5File::open(file).read_rows("/model_effort", 0, 6);
    EXPECT_EQ(missed.largest_error, out_of_reach ? effort.col(1).maxCoeff() : 0);
    EXPECT_EQ(missed.sentence().empty(), !out_of_reach);
  }
  std::filesystem::remove(file);
  const MissedPromise three{.scenes = 3, .of = 500, .model_error = 0.05, .largest_error = 0.0012};
  EXPECT_EQ(
      three.sentence(),
      "3 of 500 scenes have voltages whose estimated error is above 0.05 of the noise, at most "
      "0.0012 V");
  const MissedPromise one{
      .scenes = 1, .of = 1, .model_error = 1, .is_noisy = false, .largest_error = 2};
  EXPECT_EQ(one.sentence(),
            "1 of 1 scenes has voltages whose estimated error is above 1 of the noise of 80 dB, at "
            "most 2 V");
}

TEST(AutoDataset, StrongContactsOnElectrodesKeepThePromise) {
  nlohmann::json object = auto_set(1);
  for (const double ratio : {1e-3, 1e-6, 1e3}) {
    const nlohmann::json contact = {
        {"shape", "disc"}, {"centre", {0.75, 1}}, {"radius", 0.3}, {"conductivity_ratio", ratio}};
    object["scenes"] = nlohmann::json::array({{{"contacts", nlohmann::json::array({contact})}}});
    const DatasetSpec spec = auto_spec(object);
    const SceneModel model(spec.sensor, spec.model);
    const DatasetBlock block = generate_block(spec, model, 0, 1);
    EXPECT_LE(block.effort(0, 1), 0.25 * (block.voltages - block.clean_voltages).norm()) << ratio;
  }
}

TEST(AutoDataset, FinerBoundTakesMorePoints) {
  nlohmann::json object = auto_set(20);
  const DatasetSpec coarse = auto_spec(object);
  object["model_error"] = 0.01;
  const DatasetSpec fine = auto_spec(object);
  const SceneModel model(coarse.sensor, coarse.model);
  EXPECT_GT(generate_block(fine, model, 0, 20).effort.col(0).sum(),
            generate_block(coarse, model, 0, 20).effort.col(0).sum());
}

TEST(AutoDataset, DrawsOfAnotherSetAreItsScenesAndNoise) {
  nlohmann::json object = auto_set(5);
  const DatasetSpec original = auto_spec(object);
  object["draws_of"] = "test";
  object["grid"] = 48;
  const DatasetSpec other = auto_spec(object, "test_48");
  for (std::uint64_t i = 0; i < 5; ++i) {
    EXPECT_EQ(to_json(other.scene(i)), to_json(original.scene(i)));
    EXPECT_EQ(other.noise_stream(i).bits(), original.noise_stream(i).bits());
  }
}

TEST(AutoDataset, MistakesAreRefusedWithTheirPlace) {
  nlohmann::json object = auto_set(5);
  object["grid"] = "fine";
  EXPECT_NE(auto_refusal(object).find("/grid"), std::string::npos);
  object["grid"] = 48;
  object["model_error"] = 0.1;
  EXPECT_NE(auto_refusal(object).find("/model_error"), std::string::npos);
  object["grid"] = "auto";
  object["model_error"] = 0;
  EXPECT_NE(auto_refusal(object).find("/model_error"), std::string::npos);
}

}  // namespace
}  // namespace ertbench
