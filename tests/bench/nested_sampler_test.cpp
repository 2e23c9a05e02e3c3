// Nested sampling where the evidence is known, and against annealing where it is not.

#include "limit/nested_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/bench/limit_testing.h"

namespace ertbench {
namespace {

using testing::KnownLikelihood;
using testing::prior_of_a_disc;

/// Log of a Gaussian of the height 1 around a place of the first contact.
double log_gaussian(const Scene& scene, const Eigen::Vector2d& place, double width) {
  return -(scene.contacts.front().centroid() - place).squaredNorm() / (2 * width * width);
}

/// Its integral over the prior: centres of discs of radius 0.2 are uniform over 1.6 x 1.6.
double evidence_of(double width) { return 2 * std::numbers::pi * width * width / (1.6 * 1.6); }

struct Runs {
  double mean = 0;       ///< of the errors of the log evidence, in units of its deviation
  double deviation = 0;  ///< of these
};

/// Runs of nested sampling against the right evidence.
Runs errors_of(const SceneLikelihood& likelihood, double right, int runs) {
  const PlaceMetric metric(Eigen::Matrix3d(100 * Eigen::Matrix3d::Identity()));
  Runs out;
  double squares = 0;
  for (int seed = 0; seed < runs; ++seed) {
    RandomStream random(static_cast<std::uint64_t>(seed), key_of("nested"), 0, Purpose::scene);
    std::uint64_t solves = 0;
    const Evidence found =
        nested_evidence(prior_of_a_disc(), likelihood, metric, {.live = 60}, random, solves);
    EXPECT_GT(solves, 60U);
    const double error = (found.log - std::log(right)) / found.deviation;
    out.mean += error / runs;
    squares += error * error / runs;
  }
  out.deviation = std::sqrt(squares - out.mean * out.mean);
  return out;
}

// The errors have the deviation that is said, and none of them is common to all runs.
TEST(NestedSampler, FindsTheEvidenceOfAGaussian) {
  constexpr double width = 0.01;
  const KnownLikelihood likelihood([&](const Scene& scene) {
    return log_gaussian(scene, {0.3, -0.4}, width);
  });
  constexpr int runs = 60;
  const Runs errors = errors_of(likelihood, evidence_of(width), runs);
  EXPECT_NEAR(errors.mean, 0, 4 / std::sqrt(runs));
  EXPECT_NEAR(errors.deviation, 1, 0.4);
}

TEST(NestedSampler, FindsTheEvidenceOfTwoGaussians) {
  const KnownLikelihood likelihood([](const Scene& scene) {
    return std::log(std::exp(log_gaussian(scene, {0.3, -0.4}, 0.02)) +
                    4 * std::exp(log_gaussian(scene, {-0.5, 0.5}, 0.04)) + 1e-300);
  });
  constexpr int runs = 60;
  const double right = evidence_of(0.02) + 4 * evidence_of(0.04);
  const Runs errors = errors_of(likelihood, right, runs);
  EXPECT_NEAR(errors.mean, 0, 4 / std::sqrt(runs));
  EXPECT_NEAR(errors.deviation, 1, 0.4);
}

TEST(NestedSampler, KnowsThatThereIsOneSceneWithoutContact) {
  const KnownLikelihood likelihood(
      [](const Scene& scene) { return -3.5 - static_cast<double>(scene.contacts.size()); });
  const PlaceMetric metric(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  RandomStream random(1, key_of("nested"), 0, Purpose::scene);
  std::uint64_t solves = 0;
  const ScenePrior prior = prior_of_a_disc().with_contacts(0);
  const Evidence found = nested_evidence(prior, likelihood, metric, {}, random, solves);
  EXPECT_EQ(found.log, -3.5);
  EXPECT_EQ(found.deviation, 0);
}

}  // namespace
}  // namespace ertbench
