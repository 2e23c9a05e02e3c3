// What networks take from the physics: a first dense layer, and the blur of a target.

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "core/hdf5_file.h"
#include "forward/fem/forward_model.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/tensor_file.h"
#include "models/solvers/learned_solver.h"
#include "models/training/standardisation.h"
#include "tests/models/models_testing.h"

namespace ertbench {
namespace {

using namespace testing;

TEST(Sensitivity, DenseLayerBeginsAsOneStepGaussNewton) {
  const TrainingFiles files;
  const FitInput input = files.input();
  const Standardisation standardisation = Standardisation::of(*input.training);
  torch::nn::Linear layer(208, 576);
  set_sensitivity_inverse(layer, input, standardisation);

  const auto gauss_newton = make_solver({{"type", "one-step-gn"}, {"prior", "noser"}});
  gauss_newton->fit(input);
  const Frames changes = random_changes(4);
  const Images expected = reconstruct(*gauss_newton, changes).images;
  const torch::Tensor y = layer->forward(standardisation.apply(changes)).detach().contiguous();
  const Images images =
      -input.sensor.background *
      Eigen::Map<const Eigen::Matrix<float, 4, 576, Eigen::RowMajor>>(y.data_ptr<float>())
          .cast<double>();
  EXPECT_LT(relative_difference(images, expected), 1e-4);  // float32, sums of 208 large products
}

// It is the best affine estimate of its own scenes.
TEST(Sensitivity, TheLinearEstimateIsABetterFirstImageOfItsScenes) {
  const TrainingFiles files(400, 100);
  const FitInput input = files.input();
  const auto error_of_first_images = [&](const char* initialisation) {
    const auto solver = make_learned({{"type", "dd-ert"},
                                      {"width", 1},
                                      {"convolutions", 1},
                                      {"alpha", 0},
                                      {"train_dense", false},
                                      {"initialisation", initialisation},
                                      {"epochs", 1}});
    solver->fit(input);
    const TemporaryFolder folder("start");
    solver->save(folder / "dd-ert.h5");
    DdErtGenerator network(input.sensor, {.width = 1, .convolutions = 1});
    const NamedTensors weights = weights_of(network);
    copy_values(read_tensors(Hdf5File::open(folder / "dd-ert.h5"), "/network", weights), weights);
    const Standardisation standardisation = Standardisation::of(*input.training);
    const Frames changes = input.training->voltages(0, 400).rowwise() -
                           input.training->reference_voltages().transpose();
    const torch::NoGradGuard no_gradients;
    const torch::Tensor y = network.initial_imaging()->forward(standardisation.apply(changes));
    const Images truths =
        1 - input.training->conductivity(0, 400).array() / input.sensor.background;
    const Eigen::MatrixXd images =
        Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
            y.contiguous().data_ptr<float>(), 400, truths.cols())
            .cast<double>();
    return (images - truths).norm() / truths.norm();
  };
  EXPECT_LT(error_of_first_images("lmmse"), 0.8 * error_of_first_images("physics"));
}

TEST(Sensitivity, BlurIsGaussNewtonOfTheJacobianCutAtAQuarter) {
  const TrainingFiles files;
  FitInput input = files.input();
  const RowMajorMatrix blur = spatial_blur(input, 0.05);
  const RowMajorMatrix jacobian = ForwardModel(input.sensor, 24).jacobian();
  const auto gauss_newton =
      make_solver({{"type", "one-step-gn"}, {"prior", "laplace"}, {"lambda", 0.05}});
  gauss_newton->fit(input);
  for (const Eigen::Index pixel : {0, 300, 575}) {
    const Eigen::RowVectorXd image =
        reconstruct(*gauss_newton, jacobian.col(pixel).transpose()).images.row(0);
    for (Eigen::Index p = 0; p < 576; ++p) {
      const bool kept = image[p] >= 0.25 * image.maxCoeff();
      EXPECT_NEAR(blur(p, pixel), kept ? image[p] : 0, 1e-9);
    }
  }
}

// The paper's networks know falls of the conductivity alone; where a training set has rises, its
// largest is at y = .9, and a network that begins as one-step Gauss-Newton still does.
TEST(ImageUnit, IsSetByRisesAndLeavesFallsAlone) {
  const TrainingFiles falls;
  EXPECT_EQ(Standardisation::of(*falls.input().training).image, 1);

  const TemporaryFolder folder("rises");
  DatasetSpec spec = random_contacts(40);
  std::get<SceneDistribution>(spec.scenes).conductivity_ratio = {2, 5};
  generate_dataset(spec, folder / "rises.h5");
  const DatasetFile rises(folder / "rises.h5");
  const Standardisation standardisation = Standardisation::of(rises);
  const double largest = rises.conductivity(0, 40).maxCoeff() / Sensor{}.background;
  EXPECT_NEAR(standardisation.image, (1 - largest) / 0.9, 1e-12);
}

}  // namespace
}  // namespace ertbench
