// The lean network: its start is the linear estimate of least mean squared error.

#include "models/networks/lean_net.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "core/random.h"
#include "models/training/objective.h"
#include "models/training/standardisation.h"
#include "tests/models/models_testing.h"

namespace ertbench {
namespace {

using namespace testing;

RowMajorMatrix gaussian(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  RandomStream random(seed, 0, 0, Purpose::noise);
  RowMajorMatrix out(rows, columns);
  for (Eigen::Index i = 0; i < out.size(); ++i) out.data()[i] = random.normal();
  return out;
}

/// x Gaussian with covariance P P^T, v = H x + m + s n: the estimate in closed form is
/// E[x|v] = C H^T (H C H^T + s^2)^-1 (v - m).
TEST(LinearEstimate, OfGaussianVectorsIsTheConditionalMean) {
  constexpr Eigen::Index examples = 200000;
  constexpr double deviation = 0.5;
  const RowMajorMatrix factor = gaussian(4, 4, 1);
  const RowMajorMatrix map = gaussian(6, 4, 2);
  const Eigen::RowVectorXd mean = gaussian(1, 6, 3);
  const RowMajorMatrix x = gaussian(examples, 4, 4) * factor.transpose();
  const RowMajorMatrix v =
      (x * map.transpose() + deviation * gaussian(examples, 6, 5)).rowwise() + mean;
  LinearEstimate estimate(6, 4);
  estimate.add(v.topRows(1000), x.topRows(1000));
  estimate.add(v.bottomRows(examples - 1000), x.bottomRows(examples - 1000));
  const LinearEstimate::Affine found = estimate.solve();

  const Eigen::MatrixXd covariance = factor * factor.transpose();
  const Eigen::MatrixXd of_v =
      map * covariance * map.transpose() + deviation * deviation * Eigen::MatrixXd::Identity(6, 6);
  const Eigen::MatrixXd expected = covariance * map.transpose() * of_v.inverse();
  // The weights of a regression have errors of the residual over noise and root of the count.
  EXPECT_LE((found.weights - expected).norm(), 0.02 * expected.norm());
  EXPECT_LE((found.offset + expected * mean.transpose()).norm(), 0.02 * expected.norm());
}

TEST(LinearEstimate, LeavesNoErrorThatItsInputsCouldExplain) {
  const RowMajorMatrix v = gaussian(300, 5, 6).array().square();
  const RowMajorMatrix x = (v * gaussian(5, 3, 7)).array().sin();
  LinearEstimate estimate(5, 3);
  estimate.add(v, x);
  const LinearEstimate::Affine found = estimate.solve();
  const RowMajorMatrix errors =
      x - ((v * found.weights.transpose()).rowwise() + found.offset.transpose());
  EXPECT_LE(errors.colwise().mean().cwiseAbs().maxCoeff(), 1e-10);
  // The ridge leaves a millionth.
  const RowMajorMatrix centred = v.rowwise() - v.colwise().mean();
  EXPECT_LE((errors.transpose() * centred / 300).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(LeanNet, BeginsWithTheImageThatItIsGiven) {
  torch::manual_seed(1);
  const torch::NoGradGuard no_gradients;
  LeanNet network(Sensor{}, {.width = 4, .bounded = false});
  network.eval();
  for (const auto& item : network.named_parameters()) {
    if (item.key() == "image.weight") item.value().zero_();  // no correction
  }
  const torch::Tensor weights = torch::randn({576, 104});
  const torch::Tensor bias = torch::randn({576});
  network.set_first_image(weights, bias);
  const torch::Tensor frames = torch::randn({3, 208});
  const torch::Tensor expected =
      network.means_of_pairs(frames).matmul(weights.t()) + bias;  // pixel by pixel
  const torch::Tensor images = network.forward(frames).flatten(1);
  EXPECT_LE((images - expected).norm().item<double>(), 1e-5 * expected.norm().item<double>());
}

TEST(LeanNet, SeesBothChannelsOfAReciprocalPairAlike) {
  torch::manual_seed(2);
  LeanNet network(Sensor{}, {.width = 4});
  network.eval();
  const torch::Tensor frame = torch::randn({1, 208});
  torch::Tensor exchanged = frame.clone();
  for (const auto& [a, b] : reciprocal_pairs(Sensor{})) {
    exchanged[0][a] = frame[0][b];
    exchanged[0][b] = frame[0][a];
  }
  EXPECT_TRUE(network.forward(frame).allclose(network.forward(exchanged), 1e-5, 1e-7));
}

/// Before any training its error is that of the linear estimate, which no other affine one beats.
TEST(LeanNetSolver, BeginsBetterThanAnEmptyImage) {
  const TrainingFiles files(400, 100);
  nlohmann::json spec = {{"type", "lean-net"}, {"width", 4},   {"output", "linear"},
                         {"epochs", 1},        {"batch", 400}, {"learning_rate", 1e-9}};
  const auto validation_error = [&](const char* initialisation) {
    spec["initialisation"] = initialisation;
    const auto solver = make_learned(spec);
    solver->fit(files.input());
    return solver->parameters().at("training").at("validation_error").get<double>();
  };
  EXPECT_LT(validation_error("lmmse"), 0.95);
  EXPECT_GT(validation_error("random"), 1);
}

TEST(RelativeErrorObjective, IsTheRelativeErrorOfTheTables) {
  const torch::Tensor truths = torch::zeros({2, 1, 24, 24});
  truths.slice(2, 3, 9).fill_(0.5);
  const torch::Tensor images = truths * 0.7;
  std::vector<double> terms;
  const double loss = RelativeError().loss(images, truths, terms).item<double>();
  EXPECT_NEAR(loss, 0.3, 0.01);  // the two floors change it by some thousandths
  // A blank frame without error costs nothing to speak of, one with an error something finite.
  const torch::Tensor blank = torch::zeros({1, 1, 24, 24});
  EXPECT_LT(RelativeError().loss(blank, blank, terms).item<double>(), 0.02);
  EXPECT_GT(RelativeError().loss(blank + 0.1, blank, terms).item<double>(), 1);
}

}  // namespace
}  // namespace ertbench
