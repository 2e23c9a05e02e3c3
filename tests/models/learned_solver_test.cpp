// What every solver promises (solvers/solver.h), for the learned ones, through the plugin.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "forward/errors.h"
#include "tests/models/models_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;
using ::testing::HasSubstr;

const json specs[] = {
    {{"type", "fcnn"}, {"widths", {64, 32}}},
    {{"type", "dcnn"}, {"widths", {8, 8, 16}}},
    {{"type", "eit-nn"}, {"dense_widths", {64, 576}}, {"channels", {4, 4}}},
    {{"type", "dd-ert"}, {"width", 4}, {"convolutions", 1}, {"discriminator_widths", {4, 8}}},
};

std::unique_ptr<Solver> make_learned(const json& spec) {
  SolverRegistry registry;
  registry.load_plugin(ERTBENCH_MODELS_PLUGIN);
  return registry.make(JsonObject(spec, "spec.json", ""));
}

json with_budget(json spec) {
  spec["epochs"] = 2;
  spec["batch"] = 16;
  return spec;
}

class LearnedContract : public ::testing::TestWithParam<json> {
 protected:
  static std::unique_ptr<Solver> trained(const TrainingFiles& files) {
    std::unique_ptr<Solver> solver = make_learned(with_budget(GetParam()));
    solver->fit(files.input());
    return solver;
  }

  TrainingFiles files_;
};

TEST_P(LearnedContract, ABatchIsTheSameAsItsFrames) {
  const auto solver = trained(files_);
  const Frames changes = random_changes(100);
  const Reconstruction batch = reconstruct(*solver, changes);
  EXPECT_TRUE(batch.images.allFinite());
  for (Eigen::Index f = 0; f < changes.rows(); f += 33) {
    const Images single = reconstruct(*solver, changes.row(f)).images;
    EXPECT_LE((single - batch.images.row(f)).norm(), 1e-5 * single.norm());
  }
}

TEST_P(LearnedContract, TwoThreadsMayShareIt) {
  const auto solver = trained(files_);
  const Frames changes = random_changes(70);
  const Reconstruction alone = reconstruct(*solver, changes);
  Reconstruction first;
  Reconstruction second;
  std::thread a([&] { first = reconstruct(*solver, changes); });
  std::thread b([&] { second = reconstruct(*solver, changes); });
  a.join();
  b.join();
  EXPECT_EQ(first.images, alone.images);
  EXPECT_EQ(second.images, alone.images);
}

TEST_P(LearnedContract, ASavedSolverIsTheSameAgain) {
  const auto solver = trained(files_);
  const std::filesystem::path file = files_.folder() / "network.fitted";
  solver->save(file);
  const auto again = make_learned({{"type", GetParam()["type"]}});
  again->load(file, Sensor{});
  EXPECT_EQ(again->parameters(), solver->parameters());
  const Frames changes = random_changes(5);
  EXPECT_EQ(reconstruct(*again, changes).images, reconstruct(*solver, changes).images);

  Sensor other;
  other.drive_current = 0.01;
  EXPECT_THAT(message_of<InputError>([&] { again->load(file, other); }),
              HasSubstr("was trained for the sensor"));
  const std::string another = GetParam()["type"] == "fcnn" ? "dcnn" : "fcnn";
  EXPECT_THAT(message_of<InputError>([&] {
                make_learned({{"type", another}})->load(file, {});
              }),
              HasSubstr("not a \"" + another + "\""));
}

TEST_P(LearnedContract, FilesThatAreNoneAreRefused) {
  const auto solver = make_learned(GetParam());
  const std::filesystem::path file = files_.folder() / "none.fitted";
  EXPECT_THAT(message_of<InputError>([&] { solver->load(file, {}); }), HasSubstr("no such file"));
  std::ofstream(file) << "not an archive";
  EXPECT_THAT(message_of<InputError>([&] { solver->load(file, {}); }),
              HasSubstr("is not the file of a fitted network"));
  EXPECT_THAT(message_of<InputError>([&] { solver->load(files_.folder() / "train.h5", {}); }),
              HasSubstr("is not the file of a fitted network"));
}

TEST_P(LearnedContract, NeedsItsData) {
  FitInput input = files_.input();
  input.training = nullptr;
  EXPECT_THAT(message_of<InputError>([&] { make_learned(GetParam())->fit(input); }),
              HasSubstr("needs the dataset \"train\""));
}

TEST_P(LearnedContract, BadFramesCostOnlyThemselves) {
  const auto solver = trained(files_);
  Frames changes = random_changes(3);
  const Reconstruction good = reconstruct(*solver, changes);
  changes.row(1).setConstant(std::nan(""));
  const Reconstruction one_bad = reconstruct(*solver, changes);
  EXPECT_EQ(one_bad.reports[1].status, FrameStatus::undefined);
  EXPECT_EQ(one_bad.reports[0].status, FrameStatus::ok);
  EXPECT_LE((one_bad.images.row(2) - good.images.row(2)).norm(), 1e-5 * good.images.norm());
}

TEST_P(LearnedContract, ImagesEidorsFrames) {
  const auto solver = trained(files_);
  const Reconstruction out = reconstruct(*solver, eidors_changes());
  EXPECT_TRUE(out.images.allFinite());
}

INSTANTIATE_TEST_SUITE_P(All, LearnedContract, ::testing::ValuesIn(specs), [](const auto& test) {
  std::string name = test.param.at("type");
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  return name;
});

TEST(LearnedSolverSettings, AreCheckedWithTheirPlace) {
  const auto said = [](const json& spec) {
    return message_of<InputError>([&] { make_learned(spec)->check(Sensor{}); });
  };
  EXPECT_THAT(said({{"type", "dd-ert"}, {"alpha", -1}}), HasSubstr("spec.json: /alpha"));
  EXPECT_THAT(said({{"type", "dd-ert"}, {"initialisation", "physic"}}), HasSubstr("\"physics\""));
  EXPECT_THAT(said({{"type", "fcnn"}, {"width", 3}}), HasSubstr("/width"));
  EXPECT_THAT(said({{"type", "fcnn"}, {"batch", 1}}), HasSubstr("/batch"));
  EXPECT_THAT(said({{"type", "dcnn"}, {"widths", {8, 8}}}), HasSubstr("/widths"));
  EXPECT_THAT(said({{"type", "eit-nn"}, {"dense_widths", {64, 32}}}), HasSubstr("576"));
  EXPECT_EQ(said({{"type", "dd-ert"}, {"alpha", 100}, {"beta", 100}}), "");
}

TEST(LearnedSolverSettings, HugeWeightsEndOneWayOrTheOther) {
  const TrainingFiles files;
  json spec = with_budget(specs[3]);
  spec["alpha"] = 100;
  spec["beta"] = 100;
  const auto solver = make_learned(spec);
  solver->fit(files.input());
  EXPECT_TRUE(reconstruct(*solver, random_changes(3)).images.allFinite());
}

}  // namespace
}  // namespace ertbench
