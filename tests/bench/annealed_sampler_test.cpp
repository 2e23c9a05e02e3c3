// Annealing on targets whose posterior is known.

#include "limit/annealed_sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>

#include "forward/sheet/sheet_shapes.h"
#include "limit/frame_limit.h"
#include "tests/bench/limit_testing.h"

namespace ertbench {
namespace {

using testing::distance_from_uniform;
using testing::KnownLikelihood;
using testing::prior_of_a_disc;

/// A likelihood of which it is known how large it can be.
class BoundedLikelihood : public KnownLikelihood {
 public:
  BoundedLikelihood(std::function<double(const Scene&)> log, double largest)
      : KnownLikelihood(std::move(log)), largest_(largest) {}
  double largest() const override { return largest_; }

 private:
  double largest_;
};

ScenePrior prior_of(int least, int most, double blank = 0) {
  SceneDistribution scenes;
  scenes.contacts = {least, most};
  scenes.blank_fraction = blank;
  return {scenes, square_sheet()};
}

PosteriorSamples anneal(const ScenePrior& prior, const SceneLikelihood& likelihood,
                        const AnnealingOptions& options, std::uint64_t seed,
                        const EllipseModel* ellipses = nullptr) {
  RandomStream random(seed, key_of("limit test"), 0, Purpose::scene);
  std::vector<SceneDraw> bank;
  std::vector<Scene> scenes;
  for (int i = 0; i < 4000; ++i) {
    bank.push_back(prior.draw(random));
    scenes.push_back(scene_of(bank.back()));
  }
  const PlaceMetric metric(Eigen::Matrix3d(100 * Eigen::Matrix3d::Identity()));
  return sample_by_annealing(prior, likelihood, metric, ellipses, bank, likelihood.of(scenes),
                             options, random);
}

/// Many particles, moved often, so that errors of the moves show and those of the samples do not.
AnnealingOptions many() {
  return {.islands = 4, .particles = 500, .rounds = 20, .final_rounds = 400, .snapshots = 4};
}

double share_of(const PosteriorSamples& posterior,
                const std::function<bool(const SceneDraw&)>& holds) {
  double sum = 0;
  double all = 0;
  for (const PosteriorSample& sample : posterior.samples) {
    all += sample.weight;
    if (holds(sample.scene)) sum += sample.weight;
  }
  return sum / all;
}

/// Samples of prior_of(1, 3, 0.2), of which `independent` are worth as many.
void expect_the_prior(const PosteriorSamples& posterior, double independent) {
  std::vector<double> sizes;
  std::vector<double> ratios;
  std::vector<double> aspects;
  std::vector<double> places;
  std::vector<double> angles;
  std::array<double, 4> shapes{};
  for (const PosteriorSample& sample : posterior.samples) {
    for (const ContactDraw& c : sample.scene) {
      sizes.push_back((c.size - 0.06) / 0.34);
      ratios.push_back((c.conductivity_ratio - 0.1) / 0.8);
      aspects.push_back((c.aspect - 0.4) / 0.6);
      places.push_back((c.centre.x() / (1 - c.size) + 1) / 2);
      angles.push_back(c.angle / std::numbers::pi);
      shapes[static_cast<std::size_t>(c.shape)] += 1;
    }
  }
  // The 1 % point of the distance.
  const double distance = 1.63 / std::sqrt(independent);
  EXPECT_LT(distance_from_uniform(sizes), distance);
  EXPECT_LT(distance_from_uniform(ratios), distance);
  EXPECT_LT(distance_from_uniform(aspects), distance);
  EXPECT_LT(distance_from_uniform(places), distance);
  EXPECT_LT(distance_from_uniform(angles), distance);
  // Four standard deviations.
  const auto near = [&](double share) { return 4 * std::sqrt(share * (1 - share) / independent); };
  for (const double count : shapes) {
    EXPECT_NEAR(count / static_cast<double>(sizes.size()), 0.25, near(0.25));
  }
  const auto share = [&](std::size_t contacts) {
    return share_of(posterior, [&](const SceneDraw& s) { return s.size() == contacts; });
  };
  EXPECT_NEAR(share(0), 0.2, near(0.2));
  for (const std::size_t contacts : {1, 2, 3}) EXPECT_NEAR(share(contacts), 0.8 / 3, near(0.27));
}

// Where every scene is as likely as any other, moves of any kind must leave the prior as it is: a
// wrong Jacobian or density of one of them shifts it.
TEST(AnnealedSampler, LeavesThePriorAsItIs) {
  const KnownLikelihood flat([](const Scene&) { return 0.0; });
  expect_the_prior(anneal(prior_of(1, 3, 0.2), flat, many(), 1), 2000);
}

// The density of places depends on how much room a contact of its size has.
TEST(AnnealedSampler, LeavesThePriorOfARectangleAsItIs) {
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  const auto sheet = std::make_shared<const RectangleSheet>(Eigen::Vector2d(300, 150));
  const KnownLikelihood flat([](const Scene&) { return 0.0; });
  const PosteriorSamples posterior = anneal({scenes, sheet}, flat, many(), 9);
  std::vector<double> sizes;
  std::vector<double> across;
  std::vector<double> up;
  for (const PosteriorSample& sample : posterior.samples) {
    const ContactDraw& c = sample.scene.front();
    sizes.push_back((c.size - 0.06) / 0.34);
    across.push_back((c.centre.x() / (1 - c.size) + 1) / 2);
    up.push_back((c.centre.y() / (0.5 - c.size) + 1) / 2);
  }
  const double distance = 1.63 / std::sqrt(2000);
  EXPECT_LT(distance_from_uniform(sizes), distance);
  EXPECT_LT(distance_from_uniform(across), distance);
  EXPECT_LT(distance_from_uniform(up), distance);
}

/// As likely as any other, with a rest that asks for something all the same.
class Misleading : public SceneLikelihood {
 public:
  std::vector<SceneFit> of(std::span<const Scene> scenes,
                           std::span<const double> = {}) const override {
    std::vector<SceneFit> fits;
    for (const Scene& scene : scenes) {
      // Another one for every scene, so that the way back is not the way forth.
      const double at = scene.contacts.empty() ? 0 : 9 * scene.contacts[0].centre.x();
      fits.push_back({0, 0, 2e-3, Eigen::VectorXd::LinSpaced(208, at, at + 40).array().sin()});
    }
    return fits;
  }
};

// Where a joint step is drawn to matters for nothing but how many are taken.
TEST(AnnealedSampler, JointStepsLeaveThePriorAsItIs) {
  const EllipseModel ellipses{Sensor{}};
  expect_the_prior(
      anneal(prior_of(1, 3, 0.2), Misleading(),
             {.islands = 4, .particles = 250, .rounds = 10, .final_rounds = 160, .snapshots = 4}, 3,
             &ellipses),
      1000);
}

// Splits and merges alone change number, size, place and shape, and leave draws of the prior draws
// of the prior. Metropolis steps by the prior need no likelihood.
TEST(AnnealedSampler, SplitsAndMergesLeaveThePriorAsItIs) {
  const ScenePrior prior = prior_of(1, 3, 0.2);
  const PlaceMetric metric(Eigen::Matrix3d(Eigen::Matrix3d::Identity()));
  const SceneMoves moves(prior, metric);
  RandomStream random(13, key_of("splits"), 0, Purpose::scene);
  PosteriorSamples ends;
  int split = 0;
  int merged = 0;
  constexpr int starts = 6000;
  for (int i = 0; i < starts; ++i) {
    const SceneDraw drawn = prior.draw(random);
    SceneDraw scene = drawn;
    for (int step = 0; step < 60; ++step) {
      const auto proposal = moves.propose(Move::split, scene, 1, 1, random);
      if (!proposal) continue;
      const double log = prior.log_density(proposal->scene) - prior.log_density(scene);
      if (std::log(1 - random.uniform()) < log + proposal->log_ratio) scene = proposal->scene;
    }
    split += scene.size() > drawn.size();
    merged += scene.size() < drawn.size();
    ends.samples.push_back({scene, {}});
  }
  expect_the_prior(ends, starts);
  EXPECT_GT(split, starts / 20);
  EXPECT_GT(merged, starts / 20);
}

/// Chains of a posterior from a scene drawn from it.
PosteriorSamples chains_from(const SceneDraw& drawn, const ScenePrior& prior,
                             const SceneLikelihood& likelihood, int chains, int rounds,
                             RandomStream& random) {
  const PlaceMetric metric(Eigen::Matrix3d(100 * Eigen::Matrix3d::Identity()));
  const AnnealingOptions options = {.particles = chains, .final_rounds = rounds, .snapshots = 1};
  AnnealingIsland island(prior, likelihood, metric, nullptr, options, random);
  PosteriorSamples out;
  island.run_chains(drawn, out.samples);
  return out;
}

// Chains that start at draws of the prior, with a flat likelihood, leave draws of the prior: also
// where they add and take away contacts.
TEST(AnnealedSampler, ChainsLeaveThePriorAsItIs) {
  const ScenePrior prior = prior_of(1, 3, 0.2);
  const KnownLikelihood flat([](const Scene&) { return 0.0; });
  RandomStream random(11, key_of("chains"), 0, Purpose::scene);
  PosteriorSamples all;
  int changed = 0;
  constexpr int starts = 2000;
  for (int i = 0; i < starts; ++i) {
    const SceneDraw drawn = prior.draw(random);
    const PosteriorSample end = chains_from(drawn, prior, flat, 1, 40, random).samples.front();
    changed += end.scene.size() != drawn.size();
    all.samples.push_back(end);
  }
  expect_the_prior(all, starts);
  EXPECT_GT(changed, starts / 4);
}

// Of a Gaussian the posterior variance is known: two chains from a draw of it are as far apart as
// two independent draws once they are long, and nearer before.
TEST(AnnealedSampler, ChainsFromAGaussiansDrawsAreApartByItsVariance) {
  const ScenePrior prior = prior_of_a_disc();
  const Eigen::Vector2d centre(0.3, -0.4);
  constexpr double width = 0.02;
  const KnownLikelihood likelihood([&](const Scene& scene) {
    return -(scene.contacts.front().centre - centre).squaredNorm() / (2 * width * width);
  });
  RandomStream random(12, key_of("chains"), 0, Purpose::scene);
  const auto variance = [&](int rounds) {
    double sum = 0;
    constexpr int starts = 400;
    for (int i = 0; i < starts; ++i) {
      SceneDraw drawn = prior.draw(random);
      drawn.front().centre = centre + width * Eigen::Vector2d(random.normal(), random.normal());
      WeightedSamples places;
      const PosteriorSamples found = chains_from(drawn, prior, likelihood, 4, rounds, random);
      places.values.resize(std::ssize(found.samples), 2);
      for (const PosteriorSample& sample : found.samples) {
        places.values.row(std::ssize(places.islands)) = sample.scene.front().centre.transpose();
        places.islands.push_back(sample.island);
      }
      sum += variance_between_last(places) / starts;
    }
    return sum / (2 * width * width);
  };
  // Its standard error is at most sqrt(2 / 3 / 400 / 2), 3 %, with three degrees of freedom a
  // start.
  EXPECT_NEAR(variance(400), 1, 0.12);
  const double early = variance(4);
  EXPECT_GT(early, 0);
  EXPECT_LT(early, 0.9);
}

TEST(AnnealedSampler, CountsContactsByTheirLikelihood) {
  const ScenePrior prior = prior_of(1, 3);
  const KnownLikelihood likelihood(
      [](const Scene& scene) { return 1.5 * static_cast<double>(scene.contacts.size()); });
  const PosteriorSamples posterior = anneal(prior, likelihood, many(), 2);
  const double sum = std::exp(1.5) + std::exp(3) + std::exp(4.5);
  for (const std::size_t contacts : {1, 2, 3}) {
    const double wanted = std::exp(1.5 * static_cast<double>(contacts)) / sum;
    EXPECT_NEAR(share_of(posterior, [&](const SceneDraw& s) { return s.size() == contacts; }),
                wanted, 0.04);
  }
}

// Where it is known how well a scene can explain the frame at all, numbers of contacts that come
// nowhere near what another number has reached are given up on the way: fewer scenes are computed,
// and the posterior is the same.
TEST(AnnealedSampler, GivesUpNumbersOfContactsThatExplainNothing) {
  const auto log = [](const Scene& scene) {
    const Eigen::Vector2d off = scene.contacts.front().centre - Eigen::Vector2d(0.3, -0.4);
    const double missing = 3 - static_cast<double>(scene.contacts.size());
    return -400 * missing - off.squaredNorm() / (2 * 0.01 * 0.01);
  };
  const AnnealingOptions few{
      .islands = 2, .particles = 40, .rounds = 10, .final_rounds = 20, .snapshots = 2};
  const ScenePrior prior = prior_of(1, 3);
  const PosteriorSamples bounded = anneal(prior, BoundedLikelihood(log, 0), few, 5);
  const PosteriorSamples unbounded =
      anneal(prior, BoundedLikelihood(log, std::numeric_limits<double>::infinity()), few, 5);
  EXPECT_LT(static_cast<double>(bounded.solves), 0.8 * static_cast<double>(unbounded.solves));
  EXPECT_EQ(bounded.log_evidence, unbounded.log_evidence);
  ASSERT_EQ(bounded.samples.size(), unbounded.samples.size());
  EXPECT_EQ(share_of(bounded, [](const SceneDraw& scene) { return scene.size() == 3; }), 1);
}

// A needle that some islands find by chance: those that missed it are part of the estimate, also
// where they go on from what the others found.
TEST(AnnealedSampler, EvidenceIsRightInTheMeanWhereSomeIslandsMissTheScenes) {
  const Eigen::Vector2d at(0.3, -0.2);
  constexpr double width = 0.003;
  constexpr double height = 1e7;
  const KnownLikelihood likelihood([&](const Scene& scene) {
    const auto& contact = scene.contacts.front();
    const double off = (contact.centroid() - at).squaredNorm() / (2 * width * width);
    return std::log1p(height * std::exp(-off));
  });
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.inside = false;
  const ScenePrior prior(scenes, square_sheet());
  const AnnealingOptions options{
      .islands = 4, .particles = 10, .rounds = 2, .final_rounds = 1, .snapshots = 1};
  double sum = 0;
  int from_one = 0;
  constexpr int runs = 300;
  for (int seed = 0; seed < runs; ++seed) {
    const PosteriorSamples posterior = anneal(prior, likelihood, options, 100 + seed);
    for (const double log : posterior.log_evidence) sum += std::exp(log) / (4.0 * runs);
    from_one += posterior.one_origin;
  }
  const double right = 1 + height * 2 * std::numbers::pi * width * width / 4;
  EXPECT_NEAR(sum / right, 1, 0.35);
  EXPECT_GT(from_one, runs / 10);
}

// An island of fewer contacts that finds a poor place alone is given up halfway and goes on from
// the scenes of one that found the good place: at the posterior itself, not at the power at which
// it was given up.
TEST(AnnealedSampler, IslandsThatAreGivenUpGoOnAtThePosterior) {
  constexpr double width = 0.0005;
  const Eigen::Vector2d good(0.3, -0.4);
  const Eigen::Vector2d poor(-0.5, 0.5);
  const BoundedLikelihood likelihood(
      [&](const Scene& scene) {
        const Eigen::Vector2d at = scene.contacts.front().centre;
        const double near = (at - good).squaredNorm() / (2 * width * width);
        const double far = (at - poor).squaredNorm() / (2 * 0.01 * 0.01) + 2000;
        return -std::min(near, far) - (scene.contacts.size() == 2 ? 60 : 0);
      },
      0);
  int shared = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const PosteriorSamples posterior = anneal(
        prior_of(1, 2), likelihood,
        {.islands = 4, .particles = 10, .rounds = 20, .final_rounds = 200, .snapshots = 4}, seed);
    std::array<double, 4> variance{};
    std::array<double, 4> count{};
    for (const PosteriorSample& sample : posterior.samples) {
      const auto island = static_cast<std::size_t>(sample.island);
      variance.at(island) += (sample.scene[0].centre - good).squaredNorm() / 2;
      ++count.at(island);
    }
    if (std::find(count.begin(), count.end(), 0) != count.end()) continue;
    const double found = std::sqrt(variance[0] / count[0]);
    if (found > 0.1) continue;  // in the poor place, as all others then
    ++shared;
    for (std::size_t i = 0; i < count.size(); ++i) {
      EXPECT_LT(std::sqrt(variance.at(i) / count.at(i)), 2 * width) << seed << " " << i;
    }
  }
  EXPECT_GT(shared, 0);
}

// A sharp Gaussian in the place of the only contact: its mean and width come out, and the evidence
// is the Gaussian's integral over the prior's density.
TEST(AnnealedSampler, FindsANarrowPosterior) {
  const ScenePrior prior = prior_of_a_disc();
  const Eigen::Vector2d centre(0.3, -0.4);
  constexpr double width = 0.004;
  const KnownLikelihood likelihood([&](const Scene& scene) {
    return -(scene.contacts.front().centre - centre).squaredNorm() / (2 * width * width);
  });
  const PosteriorSamples posterior = anneal(prior, likelihood, many(), 3);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double variance = 0;
  const auto count = static_cast<double>(posterior.samples.size());
  for (const PosteriorSample& sample : posterior.samples) mean += sample.scene[0].centre / count;
  for (const PosteriorSample& sample : posterior.samples) {
    variance += (sample.scene[0].centre - centre).squaredNorm() / (2 * count);
  }
  EXPECT_LT((mean - centre).norm(), 4 * width / std::sqrt(2000.0));
  EXPECT_NEAR(std::sqrt(variance) / width, 1, 0.05);
  const double evidence = 2 * std::numbers::pi * width * width / (1.6 * 1.6);
  for (const double log : posterior.log_evidence) EXPECT_NEAR(log, std::log(evidence), 0.35);
}

// Two places explain the frame, one of them e^25 times better, narrow enough for an island to miss
// it: the islands that did go on from the other ones' scenes, and where one alone found it, that is
// said.
TEST(AnnealedSampler, SaysWhereOneIslandAloneFoundTheScenes) {
  const ScenePrior prior = prior_of_a_disc();
  const Eigen::Vector2d good(0.3, -0.4);
  const Eigen::Vector2d poor(-0.5, 0.5);
  const KnownLikelihood likelihood([&](const Scene& scene) {
    const Eigen::Vector2d at = scene.contacts.front().centre;
    const double near = (at - good).squaredNorm() / (2 * 0.002 * 0.002);
    const double far = (at - poor).squaredNorm() / (2 * 0.02 * 0.02) + 30;
    return -std::min({near, far, 80.0});
  });
  int alone = 0;
  int missed = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const PosteriorSamples posterior = anneal(
        prior, likelihood,
        {.islands = 3, .particles = 6, .rounds = 4, .final_rounds = 12, .snapshots = 2}, seed);
    const double share = share_of(
        posterior, [&](const SceneDraw& scene) { return (scene[0].centre - good).norm() < 0.05; });
    if (posterior.alone) {
      EXPECT_GT(share, 0.99) << seed;
      EXPECT_EQ(posterior.log_evidence.front(), posterior.log_evidence.back()) << seed;
    }
    alone += posterior.alone;
    missed += share < 0.01;
  }
  EXPECT_GT(missed, 0);
  EXPECT_GT(alone, 0);
}

}  // namespace
}  // namespace ertbench
