// Kernel ridge regression: its closed forms against fits that leave one out indeed and against
// numpy, and what it makes of the presses that were measured on a skin.

#include "solvers/kernel/kernel_ridge.h"

#include <gtest/gtest.h>

#include "core/errors.h"
#include "forward/data/generate.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// The circular skin of the presses.
Sensor skin_sensor() {
  const json sensor = {{"shape", "disc"}, {"diameter_mm", 171}, {"drive", "opposite"}};
  return sensor_from_json(JsonObject(sensor, "sensor", ""));
}

DatasetSpec presses(const char* name, json more = json::object()) {
  json object = {{"file", "experiments/data/skin_presses.h5"},
                 {"contact",
                  {{"radius_mm", 12},
                   {"conductivity_ratio", 0.4},
                   {"strength", {{"dataset", "/depth_mm"}, {"full", 20}}}}}};
  object.update(more);
  return dataset_spec_from_json(JsonObject(object, "test", ""), skin_sensor(), name,
                                ERTBENCH_SOURCE_DIR);
}

DatasetFile made(const TemporaryFolder& folder, const DatasetSpec& spec) {
  const std::filesystem::path file = folder / (spec.name + ".h5");
  generate_dataset(spec, file);
  return DatasetFile(file);
}

Eigen::MatrixXd places_of(const DatasetFile& set) {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(set.size()), 2);
  const std::vector<Scene> scenes = set.scenes(0, set.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    out.row(static_cast<Eigen::Index>(i)) = scenes[i].contacts.at(0).centre;
  }
  return out;
}

Frames changes_of(const DatasetFile& set) {
  return set.voltages(0, set.size()).rowwise() - set.reference_voltages().transpose();
}

double leave_one_out_error(const RowMajorMatrix& changes, const Eigen::MatrixXd& targets,
                           KernelInput input, const KernelScales& scales) {
  const RowMajorMatrix features = kernel_features(changes, input, scales.norm_weight);
  const Eigen::MatrixXd squared = squared_distances(features, features);
  const Eigen::MatrixXd kernel =
      (-squared.array() / (scales.width * median_distance(squared))).exp();
  const Eigen::MatrixXd residuals = leave_one_out(kernel, targets, {scales.lambda})[0];
  double sum = 0;
  for (Eigen::Index i = 0; i < residuals.rows(); ++i) sum += residuals.row(i).norm();
  return sum / static_cast<double>(residuals.rows());
}

TEST(KernelRegression, LeavesOneOutInClosedFormAsByFittingAnew) {
  const RowMajorMatrix features = random_matrix(25, 4, 1);
  const Eigen::MatrixXd targets = random_matrix(25, 2, 2);
  const Eigen::MatrixXd kernel = (-squared_distances(features, features).array() / 6).exp();
  const double lambda = 0.03;
  const Eigen::MatrixXd closed = leave_one_out(kernel, targets, {lambda})[0];
  for (Eigen::Index out = 0; out < 25; ++out) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < 25; ++i) {
      if (i != out) kept.push_back(i);
    }
    Eigen::MatrixXd system = Eigen::MatrixXd::Zero(25, 25);
    system.topLeftCorner(24, 24) = kernel(kept, kept);
    system.diagonal().head(24).array() += lambda;
    system.col(24).head(24).setOnes();
    system.row(24).head(24).setOnes();
    Eigen::MatrixXd right = Eigen::MatrixXd::Zero(25, 2);
    right.topRows(24) = targets(kept, Eigen::all);
    const Eigen::MatrixXd solved = system.fullPivLu().solve(right);
    const Eigen::RowVectorXd predicted = kernel(out, kept) * solved.topRows(24) + solved.row(24);
    EXPECT_LE((closed.row(out) - (targets.row(out) - predicted)).norm(), 1e-9);
  }
}

TEST(KernelRegression, GoesThroughItsFramesWithoutARidge) {
  const RowMajorMatrix changes = random_matrix(30, 6, 3);
  const Eigen::MatrixXd targets = random_matrix(30, 2, 4);
  for (const KernelInput input : {KernelInput::direction, KernelInput::raw}) {
    const KernelRegression regression(changes, targets, input, {0.5, 1e-12, 0.2});
    EXPECT_LE((regression.predict(changes) - targets).norm(), 1e-6 * targets.norm());
  }
}

TEST(KernelRegression, ComparesDirectionsWhateverTheNorm) {
  const RowMajorMatrix changes = random_matrix(30, 6, 5);
  const KernelRegression regression(changes, random_matrix(30, 2, 6), KernelInput::direction,
                                    {0.5, 1e-3, 0});
  EXPECT_LE((regression.predict(7.5 * changes) - regression.predict(changes)).norm(), 1e-12);
}

// numpy's numbers: tests/data/skin_leave_one_out.py.
TEST(KernelRidgeOnASkin, HasTheErrorsThatNumpyFinds) {
  const TemporaryFolder folder;
  const DatasetFile all = made(folder, presses("all"));
  const Frames changes = changes_of(all);
  const Eigen::MatrixXd places = 85.5 * places_of(all);
  EXPECT_NEAR(leave_one_out_error(changes, places, KernelInput::direction, {0.5, 1e-4, 0}),
              2.5379221, 1e-5);
  EXPECT_NEAR(leave_one_out_error(changes, places, KernelInput::raw, {1, 1e-2, 0}), 4.9306721,
              1e-5);
  Eigen::MatrixXd depths(changes.rows(), 1);
  const std::vector<Scene> scenes = all.scenes(0, all.size());
  for (Eigen::Index i = 0; i < depths.rows(); ++i) {
    const Contact& contact = scenes[static_cast<std::size_t>(i)].contacts[0];
    depths(i, 0) = (1 - contact.conductivity_ratio) / 0.6 * 20;
  }
  EXPECT_NEAR(leave_one_out_error(changes, depths, KernelInput::direction, {0.5, 1e-3, 1}),
              0.4730951, 1e-5);
}

TEST(KernelRidgeOnASkin, LocatesPressesThatItHasNotSeen) {
  const TemporaryFolder folder;
  const DatasetFile train =
      made(folder, presses("train", {{"fold", {{"number", 0}, {"part", "rest"}}}}));
  const DatasetFile test =
      made(folder, presses("test", {{"fold", {{"number", 0}, {"part", "held-out"}}}}));
  ASSERT_EQ(train.size() + test.size(), 400u);
  const json spec = {{"type", "kernel-ridge"}};
  const std::unique_ptr<Solver> solver = make_solver(spec);
  FitInput input;
  input.sensor = skin_sensor();
  input.training = &train;
  solver->fit(input);
  const double told = solver->parameters()["chosen"]["place_error_mm"];
  std::vector<std::vector<FoundContact>> found(test.size());
  solver->contact_finder()->find_contacts(changes_of(test), found);
  const Eigen::MatrixXd places = places_of(test);
  double error = 0;
  double depth_error = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_EQ(found[i].size(), 1u);
    const auto row = static_cast<Eigen::Index>(i);
    error += 85.5 * (found[i][0].place - places.row(row).transpose()).norm() / 80;
    const Contact contact = test.scenes(i, 1)[0].contacts[0];
    const double peak = (1 - contact.conductivity_ratio) * test.sensor().background;
    depth_error += std::abs(found[i][0].peak - peak) / test.sensor().background / 0.6 * 20 / 80;
  }
  // Leaving one out of the others promised as much, give or take what 80 presses scatter.
  EXPECT_LE(error, 1.6 * told);
  EXPECT_LE(depth_error, 1);  // 3.3 mm for the mean depth

  const Reconstruction out = reconstruct(*solver, changes_of(test), test.sensor());
  const PixelGrid pixels = test.sensor().image();
  for (int p = 0; p < pixels.count(); ++p) {
    if (!pixels.on_sheet(p)) {
      EXPECT_EQ(out.images.col(p).cwiseAbs().maxCoeff(), 0);
    }
  }
  // The disc's integral is the contact's strength.
  EXPECT_NEAR(-out.images.row(0).sum() * pixels.pixel_area(), found[0][0].strength,
              1e-3 * found[0][0].strength);
}

/// Mean distance from the true places, mm, of presses in the held-out fold.
double error_of(const json& spec, const DatasetFile& train, const DatasetFile& test) {
  const std::unique_ptr<Solver> solver = make_solver(spec);
  FitInput input;
  input.sensor = skin_sensor();
  input.training = &train;
  solver->fit(input);
  std::vector<std::vector<FoundContact>> found(test.size());
  solver->contact_finder()->find_contacts(changes_of(test), found);
  const Eigen::MatrixXd places = places_of(test);
  double error = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    error += 85.5 * (found[i].at(0).place - places.row(row).transpose()).norm();
  }
  return error / static_cast<double>(found.size());
}

// With few presses a map from two coordinates to the frame is learned sooner than one back from its
// 192 channels; nearest presses are apart by as much as they lie apart.
TEST(KernelRidgeOnASkin, LocatesFromFewPressesByTheLikelihood) {
  const TemporaryFolder folder;
  const json few = {{"number", 0}, {"part", "rest"}, {"slice", {0, 50}}};
  const DatasetFile train = made(folder, presses("train", {{"fold", few}}));
  const DatasetFile test =
      made(folder, presses("test", {{"fold", {{"number", 0}, {"part", "held-out"}}}}));
  const double regression = error_of({{"type", "kernel-ridge"}}, train, test);
  const double likelihood =
      error_of({{"type", "kernel-ridge"}, {"position", "likelihood"}}, train, test);
  const double nearest = error_of({{"type", "kernel-ridge"}, {"position", "nearest"}}, train, test);
  EXPECT_LE(likelihood, 0.6 * regression);  // 2.5 mm and 7.5 mm by numpy
  EXPECT_LE(likelihood, 0.6 * nearest);
  EXPECT_LE(nearest, 40);  // two thirds of the radius: the middle, always
}

// A frame that is some other's, times any factor, is at its place: exact frames of a smooth skin.
TEST(PositionLikelihood, FindsThePlaceOfAFrameOfAnyAmplitude) {
  const Eigen::MatrixXd places = random_matrix(150, 2, 1).cwiseMax(-1).cwiseMin(1);
  const Eigen::MatrixXd centres = random_matrix(30, 2, 2);
  const RowMajorMatrix frames = (-squared_distances(places, centres).array()).exp();
  const RowMajorMatrix learned = frames.topRows(140);
  const Eigen::MatrixXd known = places.topRows(140);
  const PositionLikelihood model(learned, known, choose_likelihood(learned, known).scales);
  double error = 0;
  for (Eigen::Index i = 140; i < 150; ++i) {
    const Eigen::Vector2d found = model.position(7.5 * frames.row(i));
    EXPECT_LE((found - model.position(frames.row(i))).norm(), 1e-9);
    error += (found - places.row(i).transpose()).norm() / 10;
  }
  EXPECT_LE(error, 0.1);  // two steps of the grid
}

TEST(KernelRidgeOnASkin, RefusesASetWithoutPlaces) {
  const TemporaryFolder folder;
  Hdf5File file = Hdf5File::create(folder / "frames.h5");
  file.write_matrix("/voltages", random_matrix(10, 192, 1));
  file.write_vector("/reference_voltages", Eigen::VectorXd::Zero(192));
  file.close();
  const DatasetFile unknown = made(
      folder,
      presses("train", {{"file", (folder / "frames.h5").string()}, {"contact", json::object()}}));
  FitInput input;
  input.sensor = skin_sensor();
  input.training = &unknown;
  const std::string message = message_of<InputError>([&] {
    make_solver({{"type", "kernel-ridge"}})->fit(input);
  });
  EXPECT_NE(message.find("frames with one contact each"), std::string::npos) << message;
}

}  // namespace
}  // namespace ertbench
