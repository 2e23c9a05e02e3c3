// Modules from PyTorch, against what PyTorch itself makes of the same frames
// (tests/data/torch_script/make.py wrote both).

#include <gtest/gtest.h>

#include <fstream>

#include "core/errors.h"
#include "tests/models/models_testing.h"
#include "tests/models/torch_archive.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

const std::string folder = ERTBENCH_TEST_DATA "/torch_script/";

json module_spec(const std::string& file, const json& more = json::object()) {
  json spec = {{"type", "torchscript"}, {"file", folder + file}};
  spec.update(more);
  return spec;
}

std::unique_ptr<Solver> fitted_module(const json& spec) {
  std::unique_ptr<Solver> solver = make_learned(spec);
  solver->fit(FitInput{});
  return solver;
}

std::string refusal(const json& spec) {
  return message_of<InputError>([&] { fitted_module(spec); });
}

TEST(TorchScript, GivesWhatPyTorchGives) {
  const Hdf5File eager = Hdf5File::open(folder + "eager.h5");
  const Frames changes = eager.read_rows("/changes", 0, 12);
  const json input = {{"mean", eager.read_number("/", "mean")},
                      {"std", eager.read_number("/", "std")}};
  for (const std::string name : {"small", "maps"}) {
    const Images out = eager.read_rows("/" + name, 0, 12);
    const auto change = fitted_module(module_spec(name + ".pt", {{"input", input}}));
    EXPECT_LT(relative_difference(reconstruct(*change, changes).images, out), 1e-5) << name;
    EXPECT_LT(relative_difference(reconstruct(*change, changes.row(3)).images.row(0), out.row(3)),
              1e-5)
        << name;
    const auto drop =
        fitted_module(module_spec(name + ".pt", {{"input", input}, {"output", "drop"}}));
    EXPECT_LT(relative_difference(reconstruct(*drop, changes).images, -Sensor{}.background * out),
              1e-5)
        << name;
  }
}

TEST(TorchScript, StandardisesByLists) {
  const Frames changes = Hdf5File::open(folder + "eager.h5").read_rows("/changes", 0, 12);
  json input = {{"mean", std::vector<double>(208, 2e-4)}, {"std", 1.5e-3}};
  const auto lists = fitted_module(module_spec("small.pt", {{"input", input}}));
  const auto numbers =
      fitted_module(module_spec("small.pt", {{"input", {{"mean", 2e-4}, {"std", 1.5e-3}}}}));
  EXPECT_LT(relative_difference(reconstruct(*lists, changes).images,
                                reconstruct(*numbers, changes).images),
            1e-12);
  input["mean"].erase(0);
  EXPECT_NE(refusal(module_spec("small.pt", {{"input", input}})).find("207 numbers"),
            std::string::npos);
}

TEST(TorchScript, StandardisesByTheTrainingSet) {
  const TrainingFiles files;
  const auto solver = make_learned(module_spec("small.pt", {{"input", "training"}}));
  EXPECT_TRUE(solver->needs_training());
  solver->fit(files.input());
  // The same by hand, in double precision.
  const DatasetFile& set = *files.input().training;
  const Frames dv = set.voltages(0, set.size()).rowwise() - set.reference_voltages().transpose();
  const Eigen::RowVectorXd mean = dv.colwise().mean();
  const Eigen::RowVectorXd deviation =
      (dv.rowwise() - mean).colwise().squaredNorm().array().sqrt() /
      std::sqrt(static_cast<double>(dv.rows()));
  const auto list = [](const Eigen::RowVectorXd& row) {
    return std::vector<double>(row.begin(), row.end());
  };
  const auto given = fitted_module(
      module_spec("small.pt", {{"input", {{"mean", list(mean)}, {"std", list(deviation)}}}}));
  EXPECT_LT(relative_difference(reconstruct(*solver, dv).images, reconstruct(*given, dv).images),
            1e-5);

  solver->save(files.folder() / "x.fitted");
  const auto loaded = make_learned(module_spec("small.pt", {{"input", "training"}}));
  loaded->load(files.folder() / "x.fitted", Sensor{});
  EXPECT_EQ(reconstruct(*loaded, dv).images, reconstruct(*solver, dv).images);
}

TEST(TorchScript, RefusesWhatDoesNotFit) {
  EXPECT_NE(refusal(module_spec("wrong_shape.pt")).find("gives [2, 10]; it must be [2, 576]"),
            std::string::npos)
      << refusal(module_spec("wrong_shape.pt"));
  EXPECT_NE(refusal(module_spec("make.py")).find("is no TorchScript module"), std::string::npos);
  EXPECT_EQ(refusal(module_spec("absent.pt")).find("spec.json: /file: "), 0u);
  EXPECT_EQ(refusal(module_spec("small.pt", {{"input", {{"mean", 0}, {"std", 0}}}}))
                .find("spec.json: /input/std: must be a number"),
            0u);
  EXPECT_EQ(refusal(module_spec("small.pt", {{"output", "sigma"}})).find("spec.json: /output: "),
            0u);
  EXPECT_EQ(refusal(module_spec("small.pt", {{"seed", 3}}))
                .find("spec.json: /seed: the file is the "
                      "same for every seed"),
            0u);
  json other = module_spec("small.pt");
  const std::unique_ptr<Solver> solver = make_learned(other);
  FitInput input;
  input.sensor.electrode_count = 8;
  input.sensor.electrode_offset = 0.5;
  const std::string message = message_of<InputError>([&] { solver->fit(input); });
  EXPECT_NE(message.find("for frames [2, 40] the module fails"), std::string::npos) << message;
}

TEST(TorchScript, RunsNothingWhenItIsMade) {
  const TemporaryFolder work;
  write_prepared_archive(work / "prepared.pt", work / "marker");
  const auto solver =
      make_learned({{"type", "torchscript"}, {"file", (work / "prepared.pt").string()}});
  solver->check(Sensor{});
  EXPECT_FALSE(std::filesystem::exists(work / "marker"));
}

}  // namespace
}  // namespace ertbench
