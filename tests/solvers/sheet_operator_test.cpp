#include "solvers/iterated/sheet_operator.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "forward/fem/forward_model.h"
#include "solvers/channel_mask.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;

Eigen::VectorXd random_ratio(Eigen::Index size, std::uint64_t seed) {
  RandomStream random(seed, 0, 0, Purpose::scene);
  return Eigen::VectorXd::NullaryExpr(size, [&] { return std::exp(random.normal()); });
}

TEST(SheetOperator, HasTheVoltagesAndTheJacobianOfTheForwardModel) {
  Sensor corners;  // an electrode on the node that the factor holds
  corners.electrode_offset = 0;
  for (const Sensor& sensor : {Sensor{}, corners}) {
    const ForwardModel model(sensor, sensor.image_grid);
    const Reciprocity reciprocity(sensor);
    SheetOperator sheet(sensor);
    for (const std::uint64_t seed : {1, 2}) {
      const Eigen::VectorXd ratio = random_ratio(sensor.pixels(), seed);
      const Eigen::VectorXd conductivity = sensor.background * ratio;
      sheet.set_conductivity(ratio);
      Eigen::VectorXd changes(sheet.pairs());
      sheet.changes(pairs_without(sensor, 0), changes);
      const Frames voltages = model.solve(conductivity.transpose());
      const Eigen::VectorXd expected =
          reciprocity.reduce(voltages.row(0) - model.reference_voltages().transpose());
      EXPECT_LT(relative_difference(changes, expected), 1e-11);

      RowMajorMatrix jacobian(sheet.pairs(), sheet.pixels());
      sheet.jacobian(pairs_without(sensor, 0), jacobian);
      const Eigen::MatrixXd by_ratio =
          sensor.background * reciprocity.reduce_rows(model.jacobian(conductivity));
      EXPECT_LT(relative_difference(jacobian, by_ratio), 1e-11);
    }
  }
}

TEST(BoundedConductivity, IsALogisticCurveThroughTheBackground) {
  for (const auto& [low, high] : {std::pair{0.0, 2.0}, std::pair{0.2, 1.1}, std::pair{0.0, 50.0}}) {
    const BoundedConductivity bounds(0.06, low, high);
    const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(101, -0.5, 0.5);
    Eigen::VectorXd ratio;
    Eigen::VectorXd slope;
    bounds.ratios(t, ratio, slope);
    EXPECT_NEAR(ratio[50], 1, 1e-15);
    EXPECT_NEAR(slope[50], 1 / 0.06, 1e-12);
    EXPECT_TRUE((ratio.array() > low && ratio.array() <= high).all());
    Eigen::VectorXd above;
    Eigen::VectorXd below;
    Eigen::VectorXd ignored;
    bounds.ratios(t.array() + 1e-6, above, ignored);
    bounds.ratios(t.array() - 1e-6, below, ignored);
    EXPECT_LT(((above - below) / 2e-6 - slope).norm(), 1e-7 * slope.norm());
    // The inverse, away from the bounds.
    const Eigen::VectorXd few = t.segment(47, 7);
    bounds.ratios(few, ratio, slope);
    EXPECT_LT((bounds.variable((0.06 * ratio).array()).matrix() - few).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace ertbench
