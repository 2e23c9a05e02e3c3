#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

#include "bench/score/metric_formulas.h"
#include "core/random.h"
#include "forward/data/sheet_model.h"

namespace ertbench {
namespace {

Eigen::VectorXd reference_of(const Sensor& sensor) { return uniform_reference(sensor); }

Eigen::RowVectorXd an_image(const Sensor& sensor) {
  Eigen::RowVectorXd image = Eigen::RowVectorXd::Zero(sensor.pixels());
  image[100] = -0.02;
  image[101] = -0.01;
  return image;
}

TEST(ExplainedChange, IsAllOfALinearResponseAtAnyAmplitudeAndLevel) {
  const Sensor sensor;
  const Eigen::VectorXd reference = reference_of(sensor);
  const Eigen::RowVectorXd image = an_image(sensor);
  const Eigen::RowVectorXd change =
      (2.5 * (uniform_jacobian(sensor) * image.transpose()) - 0.04 * reference).transpose();
  const ExplainedChange explained(sensor, reference);
  EXPECT_NEAR(*explained.of(change, image), 1, 1e-6);
}

TEST(ExplainedChange, LeavesWhatIsOrthogonalToTheResponse) {
  const Sensor sensor;
  const Eigen::VectorXd reference = reference_of(sensor);
  const Eigen::RowVectorXd image = an_image(sensor);
  const Eigen::VectorXd response = uniform_jacobian(sensor) * image.transpose();
  Eigen::MatrixXd both(response.size(), 2);
  both << response, reference;
  RandomStream random(3, 0, 0, Purpose::scene);
  Eigen::VectorXd rest(response.size());
  for (double& value : rest) value = random.normal();
  rest -= both * both.householderQr().solve(rest).eval();
  rest *= response.norm() / rest.norm();
  // Of two orthogonal parts of the same norm one is left: 1 - 1 / sqrt(2).
  const ExplainedChange explained(sensor, reference);
  EXPECT_NEAR(*explained.of((response + rest).transpose(), image), 1 - std::sqrt(0.5), 1e-9);
}

TEST(ExplainedChange, OfNothingIsWhatTheLevelAloneExplains) {
  const Sensor sensor;
  const Eigen::VectorXd reference = reference_of(sensor);
  const Eigen::RowVectorXd nothing = Eigen::RowVectorXd::Zero(sensor.pixels());
  const ExplainedChange explained(sensor, reference);
  EXPECT_NEAR(*explained.of(0.01 * reference.transpose(), nothing), 1, 1e-9);
  EXPECT_FALSE(explained.of(Eigen::RowVectorXd::Zero(reference.size()), an_image(sensor)));
}

}  // namespace
}  // namespace ertbench
