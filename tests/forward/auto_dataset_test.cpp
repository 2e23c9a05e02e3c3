#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "forward/border_model.h"
#include "forward/dataset_file.h"
#include "forward/errors.h"
#include "forward/generate.h"
#include "forward/hdf5_file.h"
#include "forward/json_reader.h"
#include "forward/scene_model.h"

namespace ertbench {
namespace {

using nlohmann::json;

json mixed(int count) {
  return {{"count", count},          {"seed", 3},
          {"grid", "auto"},          {"snr_db", 50},
          {"snr_basis", "absolute"}, {"scenes", {{"blank_fraction", 0.2}}}};
}

DatasetSpec spec_of(const json& object, const std::string& name = "test") {
  return dataset_spec_from_json(JsonObject(object, "test", ""), Sensor{}, name);
}

std::string refusal(json object) {
  try {
    spec_of(object);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(AutoDataset, VoltagesAreThoseOfTheContinuousSheet) {
  const DatasetSpec spec = spec_of(mixed(20));
  const SceneModel model(spec.sensor, spec.grid);
  const DatasetBlock block = generate_block(spec, model, 0, spec.count);
  const BorderModel borders(spec.sensor);
  EXPECT_EQ(model.reference_voltages(), borders.reference_voltages());
  for (Eigen::Index i = 0; i < block.effort.rows(); ++i) {
    const Scene scene = spec.scene(static_cast<std::uint64_t>(i));
    const Eigen::VectorXd clean = block.clean_voltages.row(i);
    const double noise = (block.voltages.row(i) - block.clean_voltages.row(i)).norm();
    EXPECT_EQ(block.effort(i, 0) == 0, scene.contacts.empty());
    EXPECT_LE(block.effort(i, 1), spec.model_error * noise);
    const Eigen::VectorXd exact =
        model.reference_voltages() + borders.solve(scene, 1e-2 * noise).change;
    EXPECT_LE((clean - exact).norm(), spec.model_error * noise) << "scene " << i;
  }
}

TEST(AutoDataset, FileHoldsTheEffortAndItsRecipeReadsBack) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / "ertbench_auto_dataset_test.h5";
  std::filesystem::remove(file);
  const DatasetSpec spec = spec_of(mixed(12));
  generate_dataset(spec, file, {2, {}});
  const RowMajorMatrix effort = Hdf5File::open(file).read_rows("/model_effort", 0, 12);
  EXPECT_GT(effort.col(0).maxCoeff(), 0);
  json recipe = json::parse(DatasetFile(file).recipe());
  EXPECT_EQ(recipe.at("grid"), "auto");
  for (const char* key : {"format_version", "sensor", "name"}) recipe.erase(key);
  EXPECT_EQ(to_json(spec_of(recipe)), to_json(spec));
  std::filesystem::remove(file);
}

TEST(AutoDataset, FinerBoundTakesMorePoints) {
  json object = mixed(20);
  const DatasetSpec coarse = spec_of(object);
  object["model_error"] = 0.01;
  const DatasetSpec fine = spec_of(object);
  const SceneModel model(coarse.sensor, coarse.grid);
  EXPECT_GT(generate_block(fine, model, 0, 20).effort.col(0).sum(),
            generate_block(coarse, model, 0, 20).effort.col(0).sum());
}

TEST(AutoDataset, DrawsOfAnotherSetAreItsScenesAndNoise) {
  json object = mixed(5);
  const DatasetSpec original = spec_of(object);
  object["draws_of"] = "test";
  object["grid"] = 48;
  const DatasetSpec other = spec_of(object, "test_48");
  for (std::uint64_t i = 0; i < 5; ++i) {
    EXPECT_EQ(to_json(other.scene(i)), to_json(original.scene(i)));
    EXPECT_EQ(other.noise_stream(i).bits(), original.noise_stream(i).bits());
  }
}

TEST(AutoDataset, MistakesAreRefusedWithTheirPlace) {
  json object = mixed(5);
  object["grid"] = "fine";
  EXPECT_NE(refusal(object).find("/grid"), std::string::npos);
  object["grid"] = 48;
  object["model_error"] = 0.1;
  EXPECT_NE(refusal(object).find("/model_error"), std::string::npos);
  object["grid"] = "auto";
  object["model_error"] = 0;
  EXPECT_NE(refusal(object).find("/model_error"), std::string::npos);
}

}  // namespace
}  // namespace ertbench
