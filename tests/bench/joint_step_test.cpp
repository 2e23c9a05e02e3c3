#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "forward/border/border_model.h"
#include "limit/annealed_sampler.h"

namespace ertbench {
namespace {

ScenePrior prior_over(std::pair<double, double> aspect) {
  SceneDistribution scenes;
  scenes.contacts = {1, 3};
  scenes.aspect = aspect;
  return {scenes, square_sheet()};
}

// A step of the scale at which nothing is added to Newton's leads from near a scene back to it.
TEST(JointStep, LeadsBackToWhereTheVoltagesComeFrom) {
  const ScenePrior prior = prior_over({0.4, 1});
  const EllipseModel ellipses{Sensor{}};
  const auto voltages = border_voltages(Sensor{});
  JointStep joint(prior, ellipses);
  const SceneDraw truth = {{DrawnShape::ellipse, 0.3, {-0.4, -0.3}, 0.4, 0.6, 0.7, {}},
                           {DrawnShape::disc, 0.2, {0.5, 0.4}, 0.3, 1, 0, {}}};
  const BorderModel border{Sensor{}};
  const FrameLikelihood likelihood(
      *voltages, {100, SnrBasis::absolute},
      border.reference_voltages() + border.solve_at(scene_of(truth), 4).change);
  // x, y, log size, ratio, aspect, angle of the ellipse; x, y, log size, ratio of the disc.
  const Eigen::VectorXd away{
      {0.0004, -0.0003, 0.001, 0.0008, 0.001, 0.001, -0.0003, 0.0002, -0.001, 0.0005}};
  const SceneDraw start = joint.after(truth, away).first;
  const std::vector<SceneFit> fit = likelihood.of(std::vector<Scene>{scene_of(start)});
  const auto local = joint.around(start, fit[0], 1, std::numbers::sqrt2);
  ASSERT_TRUE(local);
  ASSERT_EQ(local->mean.size(), away.size());
  // What is left is of second order: of steps of a hundredth, with which it was found, a third.
  for (Eigen::Index q = 0; q < away.size(); ++q) {
    EXPECT_NEAR(local->mean[q], -away[q], 0.05 * std::abs(away[q])) << q;
  }
  // The density is that of the steps that are drawn: the whitened ones have the variance of one.
  RandomStream random(4, key_of("joint step"), 0, Purpose::scene);
  double sum = 0;
  constexpr int draws = 4000;
  const double top = local->log_density(local->mean);
  for (int i = 0; i < draws; ++i) sum += 2 * (top - local->log_density(local->draw(random)));
  const auto count = static_cast<double>(away.size());
  EXPECT_NEAR(sum / draws, count, 4 * std::sqrt(2 * count / draws));
}

// What has one value alone does not step away from it.
TEST(JointStep, LeavesWhatIsFixedAsItIs) {
  const ScenePrior prior = prior_over({0.5, 0.5});
  const EllipseModel ellipses{Sensor{}};
  JointStep joint(prior, ellipses);
  const SceneDraw scene = {{DrawnShape::ellipse, 0.3, {-0.4, -0.3}, 0.4, 0.5, 0.7, {}}};
  SceneFit fit;
  fit.noise = 1e-4;
  fit.rest = Eigen::VectorXd::LinSpaced(208, -1, 1);
  const auto local = joint.around(scene, fit, 1, 1);
  ASSERT_TRUE(local);
  RandomStream random(5, key_of("joint step"), 0, Purpose::scene);
  const auto [after, log_sizes] = joint.after(scene, local->draw(random));
  EXPECT_EQ(after[0].aspect, 0.5);
  EXPECT_NE(after[0].angle, scene[0].angle);
  EXPECT_NEAR(log_sizes, std::log(after[0].size / 0.3), 1e-12);
  EXPECT_TRUE(std::isfinite(prior.log_density(after)));
}

// Contacts that overlap step as well, each by what it would do alone.
TEST(JointStep, LeadsFromContactsThatOverlap) {
  const ScenePrior prior = prior_over({0.4, 1});
  const EllipseModel ellipses{Sensor{}};
  JointStep joint(prior, ellipses);
  const ContactDraw one{DrawnShape::disc, 0.2, {0.5, 0.4}, 0.3, 1, 0, {}};
  const ContactDraw two{DrawnShape::disc, 0.25, {0.3, 0.4}, 0.6, 1, 0, {}};
  SceneFit fit;
  fit.noise = 1e-4;
  fit.rest = Eigen::VectorXd::LinSpaced(208, -1, 1);
  const auto both = joint.around({one, two}, fit, 1, 1);
  ASSERT_TRUE(both);
  ASSERT_EQ(both->mean.size(), 8);
  const Eigen::MatrixXd precision = both->precision.reconstructedMatrix();
  for (const Eigen::Index c : {0, 1}) {
    const auto alone = joint.around({c == 0 ? one : two}, fit, 1, 1);
    ASSERT_TRUE(alone);
    const Eigen::MatrixXd own = alone->precision.reconstructedMatrix();
    EXPECT_LT((precision.block(4 * c, 4 * c, 4, 4) - own).norm(), 1e-9 * own.norm());
  }
}

}  // namespace
}  // namespace ertbench
