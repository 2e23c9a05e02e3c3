#include "solvers/iterated/gauss_newton.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "core/errors.h"
#include "core/random.h"
#include "forward/data/generate.h"
#include "forward/fem/forward_model.h"
#include "tests/solvers/fault_frames.h"
#include "tests/solvers/prior_matrix.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// A small sensor, so that brute force is cheap.
Sensor small_sensor() {
  Sensor sensor;
  sensor.image_grid = 8;
  return sensor;
}

/// Voltages of a smooth lump of less conductivity, without noise.
Frames lump(const Sensor& sensor) {
  const ForwardModel model(sensor, sensor.image_grid);
  Images conductivity(1, sensor.pixels());
  const PixelGrid pixels = sensor.image();
  for (int p = 0; p < sensor.pixels(); ++p) {
    const double square = (pixels.centre(p) - Eigen::Vector2d(0.3, -0.2)).squaredNorm();
    conductivity(0, p) = sensor.background * (1 - 0.6 * std::exp(-square / 0.18));
  }
  return model.solve(conductivity).rowwise() - model.reference_voltages().transpose();
}

/// The objective by its definition, from ForwardModel and the dense matrix of the prior.
class Objective {
 public:
  Objective(const Sensor& sensor, Prior prior, double lambda, const Frames& changes)
      : sensor_(sensor),
        model_(sensor, sensor.image_grid),
        bounds_(sensor.background, 0, 2),
        matrix_(lambda * lambda * prior_matrix(prior, model_.jacobian())),
        changes_(changes) {}

  double operator()(const Eigen::VectorXd& t) const {
    Eigen::VectorXd ratio;
    Eigen::VectorXd slope;
    bounds_.ratios(t, ratio, slope);
    const Frames voltages = model_.solve((sensor_.background * ratio).transpose());
    return (voltages - model_.reference_voltages().transpose() - changes_).squaredNorm() / 2 +
           t.dot(matrix_ * t) / 2;
  }
  Eigen::VectorXd variable(const Eigen::RowVectorXd& image) const {
    return bounds_.variable((image.transpose().array() + sensor_.background)).matrix();
  }

  Eigen::VectorXd gradient(const Eigen::VectorXd& t) const {
    Eigen::VectorXd ratio;
    Eigen::VectorXd slope;
    bounds_.ratios(t, ratio, slope);
    const Eigen::VectorXd conductivity = sensor_.background * ratio;
    const Frames voltages = model_.solve(conductivity.transpose());
    const Eigen::VectorXd residual =
        (voltages - model_.reference_voltages().transpose() - changes_).transpose();
    const Eigen::VectorXd by_conductivity = model_.jacobian(conductivity).transpose() * residual;
    return sensor_.background * slope.cwiseProduct(by_conductivity) + matrix_ * t;
  }

  /// BFGS, which knows no Jacobian but in the gradient.
  Eigen::VectorXd minimum() const {
    Eigen::VectorXd t = Eigen::VectorXd::Zero(sensor_.pixels());
    const Eigen::MatrixXd jacobian = model_.jacobian();
    Eigen::MatrixXd inverse = (jacobian.transpose() * jacobian + matrix_ +
                               1e-9 * Eigen::MatrixXd::Identity(t.size(), t.size()))
                                  .inverse();
    Eigen::VectorXd g = gradient(t);
    const double start = g.norm();
    for (int i = 0; i < 3000 && g.norm() > 1e-9 * start; ++i) {
      const Eigen::VectorXd direction = -inverse * g;
      const double now = (*this)(t);
      double length = 1;
      while (length > 1e-12 &&
             (*this)(t + length * direction) > now + 1e-4 * length * g.dot(direction)) {
        length /= 2;
      }
      const Eigen::VectorXd step = length * direction;
      const Eigen::VectorXd before = g;
      t += step;
      g = gradient(t);
      const Eigen::VectorXd y = g - before;
      const double sy = step.dot(y);
      if (!(sy > 0)) continue;
      const Eigen::MatrixXd turn =
          Eigen::MatrixXd::Identity(t.size(), t.size()) - step * y.transpose() / sy;
      inverse = (turn * inverse * turn.transpose() + step * step.transpose() / sy).eval();
    }
    return t;
  }

 private:
  Sensor sensor_;
  ForwardModel model_;
  BoundedConductivity bounds_;
  Eigen::MatrixXd matrix_;
  Frames changes_;
};

class GaussNewtonPrior : public ::testing::TestWithParam<Prior> {};

TEST_P(GaussNewtonPrior, FindsTheMinimumThatBruteForceFinds) {
  const Sensor sensor = small_sensor();
  const Frames changes = lump(sensor);
  for (const double lambda : {0.003, 0.03}) {
    const Objective objective(sensor, GetParam(), lambda, changes);
    const json spec = {{"type", "gauss-newton"},
                       {"prior", name_of(GetParam())},
                       {"lambda", lambda},
                       {"tolerance", 1e-9},
                       {"max_iterations", 200}};
    const Reconstruction out = reconstruct(*fitted(spec, sensor), changes, sensor);
    EXPECT_EQ(out.reports[0].status, FrameStatus::ok);
    const Eigen::VectorXd ours = objective.variable(out.images.row(0));
    const Eigen::VectorXd slow = objective.minimum();
    EXPECT_LT(objective.gradient(slow).norm(), 1e-6 * objective.gradient(0 * slow).norm());
    EXPECT_LT(objective.gradient(ours).norm(), 1e-6 * objective.gradient(0 * slow).norm());
    EXPECT_NEAR(objective(ours), objective(slow), 1e-8 * objective(slow)) << lambda;
    EXPECT_LT(relative_difference(ours, slow), 1e-3) << lambda;
  }
}

TEST_P(GaussNewtonPrior, TendsToTheOneStepImageForSmallChanges) {
  // F(t) = J t + O(t^2): the images of changes scaled by 1e-6 differ by about that.
  const Frames changes = 1e-6 * random_changes(2);
  const json prior = {{"prior", name_of(GetParam())}, {"lambda", 0.05}};
  json one = prior;
  one["type"] = "one-step-gn";
  json iterated = prior;
  iterated["type"] = "gauss-newton";
  EXPECT_LT(relative_difference(reconstruct(*fitted(iterated), changes).images,
                                reconstruct(*fitted(one), changes).images),
            1e-4);
}

INSTANTIATE_TEST_SUITE_P(All, GaussNewtonPrior,
                         ::testing::Values(Prior::tikhonov, Prior::noser, Prior::laplace),
                         [](const auto& instance) { return name_of(instance.param); });

TEST(GaussNewton, ConvergesQuadraticallyWhereTheMisfitVanishes) {
  const Sensor sensor = small_sensor();
  const Frames changes = lump(sensor);
  const auto image_after = [&](int iterations) -> Eigen::VectorXd {
    const json spec = {{"type", "gauss-newton"},
                       {"prior", "tikhonov"},
                       {"lambda", 1e-6},
                       {"tolerance", 1e-10},
                       {"max_iterations", iterations}};
    return reconstruct(*fitted(spec, sensor), changes, sensor).images.row(0);
  };
  const Eigen::VectorXd end = image_after(200);
  const auto error_after = [&](int iterations) {
    return (image_after(iterations) - end).norm() / end.norm();
  };
  ASSERT_LT(error_after(4), 0.1);
  for (const int i : {4, 5}) EXPECT_LT(error_after(i + 1), 3 * std::pow(error_after(i), 2)) << i;
}

TEST(GaussNewton, IsFreeOfTheBiasOfTheLinearModel) {
  // A disc of the ratio f has the dipole strength of 2 / (1 + f) times its change: 1.25 for f =
  // 0.6.
  const Sensor sensor;
  const ForwardModel model(sensor, 24);
  Images conductivity = Images::Constant(3, sensor.pixels(), sensor.background);
  const PixelGrid pixels = sensor.image();
  const Eigen::Vector2d centres[] = {{0, 0}, {0.5, 0}, {0.55, 0.55}};
  for (Eigen::Index f = 0; f < 3; ++f) {
    for (int p = 0; p < sensor.pixels(); ++p) {
      if ((pixels.centre(p) - centres[f]).norm() < 0.25) conductivity(f, p) *= 0.6;
    }
  }
  const Frames changes =
      model.solve(conductivity).rowwise() - model.reference_voltages().transpose();
  const auto amplitudes = [&](const char* type) -> Eigen::VectorXd {
    const json spec = {{"type", type}, {"prior", "noser"}, {"lambda", 1e-3}};
    const Images images = reconstruct(*fitted(spec), changes).images;
    return images.rowwise().sum().cwiseQuotient(
        (conductivity.array() - sensor.background).matrix().rowwise().sum());
  };
  const Eigen::VectorXd linear = amplitudes("one-step-gn");
  const Eigen::VectorXd iterated = amplitudes("gauss-newton");
  for (Eigen::Index f = 0; f < 3; ++f) {
    EXPECT_NEAR(linear[f], 1.25, 0.05);
    EXPECT_NEAR(iterated[f], 1, 0.06);
  }
}

TEST(GaussNewton, KeepsConductivitiesWithinTheirBounds) {
  const Sensor sensor;
  Frames changes = random_changes(6);
  changes.row(0) *= 30;
  changes.row(1) *= -30;
  const json spec = {{"type", "gauss-newton"}, {"lambda", 0.01}, {"bounds", {0.3, 1.2}}};
  const Images images = reconstruct(*fitted(spec), changes).images;
  EXPECT_GE(images.minCoeff(), -0.7 * sensor.background);
  EXPECT_LE(images.maxCoeff(), 0.2 * sensor.background * (1 + 1e-12));
}

TEST(GaussNewton, TotalVariationLowersItsObjectiveToAMinimum) {
  const Sensor sensor = small_sensor();
  const Frames changes = lump(sensor);
  const BoundedConductivity bounds(sensor.background, 0, 2);
  const double weight = 1e-6;
  const double smoothing = 0.01 * sensor.background;
  const RowMajorMatrix jacobian =
      sensor.background *
      Reciprocity(sensor).reduce_rows(ForwardModel(sensor, sensor.image_grid).jacobian());
  GaussNewtonIteration iteration(
      sensor, bounds,
      std::make_unique<EdgePenalty>(sensor.image_grid, sensor.image_grid, weight, smoothing),
      jacobian);
  GaussNewtonOptions options;
  options.tolerance = 1e-8;
  options.max_iterations = 500;
  Eigen::RowVectorXd image(sensor.pixels());
  FrameReport report;
  iteration.minimise(changes.row(0), pairs_without(sensor, 0), options, image, report);
  EXPECT_EQ(report.status, FrameStatus::ok);

  // The objective by its definition; no step along a pixel or a random direction lowers it.
  const ForwardModel model(sensor, sensor.image_grid);
  const Reciprocity reciprocity(sensor);
  EdgePenalty penalty(sensor.image_grid, sensor.image_grid, weight, smoothing);
  const auto objective = [&](const Eigen::VectorXd& t) {
    Eigen::VectorXd ratio;
    Eigen::VectorXd slope;
    bounds.ratios(t, ratio, slope);
    const Frames voltages = model.solve((sensor.background * ratio).transpose());
    const Eigen::RowVectorXd residual =
        voltages.row(0) - model.reference_voltages().transpose() - changes.row(0);
    return reciprocity.reduce(residual).squaredNorm() / 2 + penalty.value(t);
  };
  const Eigen::VectorXd t = bounds.variable(image.transpose().array() + sensor.background).matrix();
  const double least = objective(t);
  EXPECT_NEAR(iteration.objective(), least, 1e-9 * least);
  EXPECT_LT(least, 0.5 * objective(Eigen::VectorXd::Zero(t.size())));
  RandomStream random(4, 0, 0, Purpose::scene);
  for (int i = 0; i < 2 * t.size(); ++i) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(t.size());
    if (i < t.size()) {
      step[i] = 1;
    } else {
      for (double& s : step) s = random.normal();
    }
    step *= 1e-3 * t.norm() / step.norm();
    EXPECT_GE(objective(t + step), least * (1 - 1e-9));
    EXPECT_GE(objective(t - step), least * (1 - 1e-9));
  }
}

TEST(GaussNewton, LeavesOutChannelsAsIfTheyWereNotThere) {
  // A frame whose other channels are zero but for the kept ones: the minimum does not know them.
  constexpr ElectrodeSet masked = 1u << 2 | 1u << 7;
  Frames changes = random_changes(2);
  Frames dead = changes;
  for (Eigen::Index f = 0; f < 2; ++f) read_zero(dead.row(f), masked);
  const json spec = {{"type", "gauss-newton"}, {"lambda", 0.1}, {"channel_mask", {2, 7}}};
  const auto solver = fitted(spec);
  EXPECT_EQ(reconstruct(*solver, changes).images, reconstruct(*solver, dead).images);
  json detecting = spec;
  detecting["channel_mask"] = "detect";
  EXPECT_EQ(reconstruct(*fitted(detecting), dead).images, reconstruct(*solver, dead).images);
}

TEST(GaussNewton, EndsByTheNoiseThatReciprocalChannelsShow) {
  const Frames changes = random_changes(4);
  const json spec = {{"type", "gauss-newton"}, {"lambda", 0.02}, {"tolerance", 1e-8}};
  json stopped = spec;
  stopped["discrepancy"] = 1.5;
  const Reconstruction all = reconstruct(*fitted(spec), changes);
  const Reconstruction early = reconstruct(*fitted(stopped), changes);
  for (std::size_t f = 0; f < 4; ++f) {
    EXPECT_LT(early.reports[f].iterations, all.reports[f].iterations);
    EXPECT_EQ(early.reports[f].status, FrameStatus::ok);
  }
}

TEST(GaussNewton, SaysWhereItHasNotConverged) {
  const Reconstruction out =
      reconstruct(*fitted({{"type", "gauss-newton"}, {"lambda", 0.02}, {"max_iterations", 1}}),
                  random_changes(3));
  for (const FrameReport& report : out.reports) {
    EXPECT_EQ(report.status, FrameStatus::not_converged);
    EXPECT_EQ(report.iterations, 1);
  }
}

TEST(GaussNewton, LearnsItsPriorFromTheTrainingSet) {
  const ValidationFile scenes(600);
  FitInput input = scenes.input();
  input.training = input.validation;
  const auto error_of = [&](const json& spec) {
    const auto solver = make_solver(spec);
    solver->fit(input);
    return mean_relative_error(*solver, read_validation_frames(input, "test"), 1);
  };
  // Lambda is the noise where the prior is the scenes' own: 1.0e-4 V a channel.
  const double learned =
      error_of({{"type", "gauss-newton"}, {"prior", "training"}, {"lambda", 3e-4}});
  EXPECT_LT(learned, 0.95 * error_of({{"type", "one-step-gn"}, {"prior", "noser"}}));
  const auto without = make_solver({{"type", "gauss-newton"}, {"prior", "training"}});
  EXPECT_TRUE(without->needs_training());
  EXPECT_EQ(message_of<InputError>([&] {
              without->fit(FitInput{});
            }).find("gauss-newton: the prior \"training\" needs a training set"),
            0u);
}

TEST(GaussNewton, RefusesBoundsThatLeaveTheBackgroundOut) {
  const auto message = [](const json& bounds) {
    return message_of<InputError>([&] {
      make_solver({{"type", "gauss-newton"}, {"bounds", bounds}});
    });
  };
  EXPECT_EQ(message({0, 2}), "");
  EXPECT_EQ(message({0.2, 0.9}).find("spec.json: /bounds: must lie to both sides"), 0u);
  EXPECT_EQ(message({1, 2}).find("spec.json: /bounds: must lie to both sides"), 0u);
  EXPECT_NE(message({-1, 2}), "");
}

}  // namespace
}  // namespace ertbench
