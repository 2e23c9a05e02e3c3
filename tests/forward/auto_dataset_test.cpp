#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/json_reader.h"
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
