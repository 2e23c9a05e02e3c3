#include "solvers/linear/one_step_gn.h"

#include <gtest/gtest.h>

#include "core/errors.h"
#include "forward/data/sheet_model.h"
#include "forward/fem/forward_model.h"
#include "tests/solvers/prior_matrix.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

class EveryPrior : public ::testing::TestWithParam<Prior> {
 protected:
  static Images images(const Frames& changes, double lambda, const Sensor& sensor = {}) {
    const json spec = {{"type", "one-step-gn"}, {"prior", name_of(GetParam())}, {"lambda", lambda}};
    return reconstruct(*fitted(spec, sensor), changes, sensor).images;
  }
};

TEST_P(EveryPrior, SolvesTheNormalEquations) {
  const Frames changes = random_changes(4);
  const Eigen::MatrixXd jacobian = ForwardModel(Sensor{}, 24).jacobian();
  const Eigen::MatrixXd prior = prior_matrix(GetParam(), jacobian);
  for (const double lambda : {1e-6, 1e-3, 0.1, 10.0}) {
    const Eigen::MatrixXd x = images(changes, lambda).transpose();
    const Eigen::MatrixXd gradient =
        jacobian.transpose() * (jacobian * x - changes.transpose()) + lambda * lambda * (prior * x);
    // Rounding of the terms that cancel in it.
    const double scale = (jacobian.transpose() * (jacobian * x)).norm() +
                         (jacobian.transpose() * changes.transpose()).norm();
    EXPECT_LT(gradient.norm(), 1e-11 * scale) << "lambda " << lambda;
  }
}

TEST_P(EveryPrior, SolvesTheNormalEquationsOfManyChannels) {
  Sensor sensor;
  sensor.electrode_count = 40;  // 740 pairs, more than are left to the singular value decomposition
  sensor.image_grid = 12;
  const Eigen::MatrixXd jacobian = uniform_jacobian(sensor);
  const Eigen::MatrixXd prior = prior_matrix(GetParam(), jacobian);
  const Frames changes = (jacobian * Eigen::VectorXd::LinSpaced(144, -1, 2)).transpose();
  const double lambda = 0.05;
  const Eigen::MatrixXd x = images(changes, lambda, sensor).transpose();
  const Eigen::MatrixXd data = jacobian.transpose() * changes.transpose();
  const Eigen::MatrixXd gradient =
      jacobian.transpose() * (jacobian * x) - data + lambda * lambda * (prior * x);
  EXPECT_LT(gradient.norm(), 1e-9 * data.norm());
}

TEST_P(EveryPrior, FittedVoltagesApproachTheDataAsLambdaFalls) {
  const Frames changes = eidors_changes();
  const Eigen::MatrixXd jacobian = ForwardModel(Sensor{}, 24).jacobian();
  double before = 1;
  for (const double lambda : {1.0, 1e-2, 1e-4, 1e-6, 1e-8}) {
    const Eigen::MatrixXd fit = images(changes, lambda) * jacobian.transpose();
    const double misfit = relative_difference(fit, changes);
    EXPECT_LT(misfit, before) << "lambda " << lambda;
    before = misfit;
  }
  // Noise-free data are symmetric under reciprocity, and J' has full rank down to 9e-8.
  EXPECT_LT(before, 1e-4);
}

TEST_P(EveryPrior, AFittedImageOfLinearDataHasTheirSize) {
  // With lambda -> 0 J x = d is met, whatever the sensor's drive current and background.
  Sensor sensor;
  sensor.drive_current = 3;
  sensor.background = 0.5;
  const Eigen::MatrixXd jacobian = ForwardModel(sensor, 24).jacobian();
  const Frames changes = (jacobian * Eigen::VectorXd::Constant(576, 0.1)).transpose();
  const Images image = images(changes, 1e-6, sensor);
  EXPECT_LT(relative_difference(image * jacobian.transpose(), changes), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(All, EveryPrior,
                         ::testing::Values(Prior::tikhonov, Prior::noser, Prior::laplace),
                         [](const auto& instance) { return name_of(instance.param); });

TEST(OneStepGaussNewton, ALargeLambdaWithTheLaplacePriorLeavesTheBestConstant) {
  const Frames changes = eidors_changes();
  const Eigen::VectorXd constant = ForwardModel(Sensor{}, 24).jacobian().rowwise().sum();
  const json spec = {{"type", "one-step-gn"}, {"prior", "laplace"}, {"lambda", 1e8}};
  const Images images = reconstruct(*fitted(spec), changes).images;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const double best = changes.row(f).dot(constant) / constant.squaredNorm();
    EXPECT_LT((images.row(f).array() - best).abs().maxCoeff(), 1e-12 * std::abs(best));
  }
}

TEST(PriorFactors, ReproduceTheirMatrix) {
  Sensor sensor;
  sensor.image_grid = 8;
  const Eigen::MatrixXd jacobian = ForwardModel(sensor, 8).jacobian();
  for (const Prior prior : {Prior::tikhonov, Prior::noser, Prior::laplace}) {
    const Eigen::MatrixXd matrix = prior_matrix(prior, jacobian);
    const PriorFactors factors = prior_factors(prior, jacobian, 8);
    const Eigen::Index n = factors.shaping.cols();
    EXPECT_EQ(n, factors.free_constant ? 63 : 64);
    const Eigen::MatrixXd product = factors.shaping.transpose() * matrix * factors.shaping;
    EXPECT_LT((product - Eigen::MatrixXd::Identity(n, n)).norm(), 1e-12) << name_of(prior);
    const Eigen::VectorXd of_constant = matrix * Eigen::VectorXd::Ones(64);
    EXPECT_EQ(of_constant.norm() < 1e-12, factors.free_constant) << name_of(prior);
  }
}

TEST(OneStepGaussNewton, NamesWhatIsWrong) {
  const auto message = [](const json& spec) {
    return message_of<InputError>([&] { fitted(spec); });
  };
  EXPECT_EQ(message({{"type", "one-step-gn"}, {"lambda", -1}}),
            "spec.json: /lambda: must be > 0 or \"auto\", got -1");
  EXPECT_EQ(message({{"type", "one-step-gn"}, {"lambda", "automatic"}}),
            "spec.json: /lambda: must be > 0 or \"auto\", got \"automatic\"");
  EXPECT_EQ(message({{"type", "one-step-gn"}}),
            "spec.json: /lambda: \"auto\" needs a validation set; give a number");
  EXPECT_EQ(message({{"type", "one-step-gn"}, {"prior", "ridge"}, {"lambda", 1}})
                .find("spec.json: /prior: must be one of"),
            0u);
}

}  // namespace
}  // namespace ertbench
