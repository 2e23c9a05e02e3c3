// Each sampler on targets whose posterior is known, and on frames against each other.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/limit/annealed_sampler.h"
#include "bench/limit/disc_importance.h"
#include "bench/limit/enumerated_discs.h"
#include "bench/limit/estimators.h"
#include "forward/border/border_model.h"
#include "forward/border/elliptic_contact.h"

namespace ertbench {
namespace {

/// A likelihood of a scene's first quantities alone.
class KnownLikelihood : public SceneLikelihood {
 public:
  explicit KnownLikelihood(std::function<double(const Scene&)> log) : log_(std::move(log)) {}
  std::vector<SceneFit> of(std::span<const Scene> scenes,
                           std::span<const double> = {}) const override {
    std::vector<SceneFit> fits;
    for (const Scene& scene : scenes) fits.push_back({log_(scene), 0, 0, {}});
    return fits;
  }

 private:
  std::function<double(const Scene&)> log_;
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

/// Distance of Kolmogorov and Smirnov between values and a uniform distribution over 0 ... 1.
double distance_from_uniform(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double most = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    most = std::max(most, std::abs(values[i] - (static_cast<double>(i) + 0.5) /
                                                   static_cast<double>(values.size())));
  }
  return most;
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
  class Bounded : public KnownLikelihood {
   public:
    Bounded(std::function<double(const Scene&)> log, double largest)
        : KnownLikelihood(std::move(log)), largest_(largest) {}
    double largest() const override { return largest_; }

   private:
    double largest_;
  };
  const auto log = [](const Scene& scene) {
    const Eigen::Vector2d off = scene.contacts.front().centre - Eigen::Vector2d(0.3, -0.4);
    const double missing = 3 - static_cast<double>(scene.contacts.size());
    return -400 * missing - off.squaredNorm() / (2 * 0.01 * 0.01);
  };
  const AnnealingOptions few{
      .islands = 2, .particles = 40, .rounds = 10, .final_rounds = 20, .snapshots = 2};
  const ScenePrior prior = prior_of(1, 3);
  const PosteriorSamples bounded = anneal(prior, Bounded(log, 0), few, 5);
  const PosteriorSamples unbounded =
      anneal(prior, Bounded(log, std::numeric_limits<double>::infinity()), few, 5);
  EXPECT_LT(static_cast<double>(bounded.solves), 0.8 * static_cast<double>(unbounded.solves));
  EXPECT_EQ(bounded.log_evidence, unbounded.log_evidence);
  ASSERT_EQ(bounded.samples.size(), unbounded.samples.size());
  EXPECT_EQ(share_of(bounded, [](const SceneDraw& scene) { return scene.size() == 3; }), 1);
}

// A sharp Gaussian in the place of the only contact: its mean and width come out, and the evidence
// is the Gaussian's integral over the prior's density.
TEST(AnnealedSampler, FindsANarrowPosterior) {
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.shapes = {DrawnShape::disc};
  scenes.radius = {0.2, 0.2};
  const ScenePrior prior(scenes, square_sheet());
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
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.shapes = {DrawnShape::disc};
  scenes.radius = {0.2, 0.2};
  const ScenePrior prior(scenes, square_sheet());
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

TEST(ImportanceSampler, FindsBothModesOfAMixture) {
  // |x| = 0.5 measured with noise .02: two modes of half the weight each, y Gaussian.
  LaplaceProblem problem;
  problem.low = Eigen::Vector2d(-1, -1);
  problem.high = Eigen::Vector2d(1, 1);
  const auto residuals = [](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    return Eigen::Vector2d((at[0] * at[0] - 0.25) / 0.02, (at[1] - 0.1) / 0.05);
  };
  problem.residuals = residuals;
  problem.log_target = [&](std::span<const Eigen::VectorXd> points) {
    std::vector<double> logs;
    for (const Eigen::VectorXd& point : points) {
      const bool in_box = point.cwiseAbs().maxCoeff() <= 1;
      logs.push_back(in_box ? -residuals(point).squaredNorm() / 2 : -INFINITY);
    }
    return logs;
  };
  const std::vector<Eigen::VectorXd> starts = {Eigen::Vector2d(0.9, 0.9),
                                               Eigen::Vector2d(-0.7, -0.5)};
  RandomStream random(4, key_of("limit test"), 0, Purpose::scene);
  const WeightedPoints found = sample_by_importance(problem, starts, 4000, random);
  EXPECT_EQ(found.modes, 2u);
  EXPECT_LT(found.pareto_k, 0.5);
  EXPECT_GT(found.effective, 1000);
  double right = 0;
  double y = 0;
  double square = 0;
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    const double weight = found.weights[static_cast<Eigen::Index>(i)];
    if (found.points[i][0] > 0) right += weight;
    y += weight * found.points[i][1];
    square += weight * found.points[i][1] * found.points[i][1];
  }
  EXPECT_NEAR(right, 0.5, 0.05);
  EXPECT_NEAR(y, 0.1, 0.006);
  EXPECT_NEAR(std::sqrt(square - y * y), 0.05, 0.004);
}

TEST(ParetoSmoothing, FindsTheShapeOfATail) {
  RandomStream random(5, key_of("limit test"), 0, Purpose::scene);
  for (const double shape : {0.3, 0.9}) {
    Eigen::VectorXd weights(20000);
    for (double& weight : weights) weight = std::pow(1 - random.uniform(), -shape);
    const double largest = weights.maxCoeff();
    // 424 weights in the tail: the fit's standard deviation is (1 + k) / sqrt(424), .09 at most.
    EXPECT_NEAR(pareto_smoothed(weights), shape, 0.3);
    EXPECT_LE(weights.maxCoeff(), largest);
  }
}

/// One disc with all that may be free, and its frame at a signal-to-noise ratio.
struct DiscFrame {
  explicit DiscFrame(ScenePrior its_prior) : prior(std::move(its_prior)) {}

  ScenePrior prior;
  std::unique_ptr<SceneVoltages> voltages = border_voltages(Sensor{});
  Noise noise;
  SceneDraw truth;
  Eigen::VectorXd frame;
};

DiscFrame disc_frame(double snr_db, std::uint64_t number) {
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.shapes = {DrawnShape::disc};
  scenes.radius = {0.1, 0.35};
  scenes.conductivity_ratio = {0.2, 0.9};
  scenes.aspect = {1, 1};
  DiscFrame out(ScenePrior(scenes, square_sheet()));
  out.noise = {snr_db, SnrBasis::absolute};
  RandomStream random(6, key_of("limit test"), number, Purpose::scene);
  out.truth = out.prior.draw(random);
  const Scene scene = scene_of(out.truth);
  Frames clean(1, Sensor{}.channels());
  out.voltages->solve({&scene, 1}, nullptr, clean);
  out.frame = clean.row(0);
  add_noise(out.noise, out.voltages->reference(), random, out.frame);
  return out;
}

/// Frames whose importance weights are not to be believed.
int bad_tails = 0;

PosteriorSamples by_importance(const DiscFrame& disc, std::uint64_t number, int points) {
  RandomStream random(7, key_of("limit test"), number, Purpose::scene);
  const SceneBank bank = draw_bank(disc.prior, *disc.voltages, 1500, random, 1);
  const FrameLikelihood likelihood(*disc.voltages, disc.noise, disc.frame);
  WeightedPoints quality;
  PosteriorSamples out =
      sample_disc_by_importance(disc.prior, likelihood, bank.scenes,
                                likelihood.of_voltages(bank.voltages), points, random, &quality);
  if (quality.pareto_k > 0.7) ++bad_tails;
  return out;
}

/// [samples, (x, y, size, ratio)].
WeightedSamples numbers_of(const PosteriorSamples& posterior) {
  WeightedSamples out;
  out.values.resize(static_cast<Eigen::Index>(posterior.samples.size()), 4);
  out.weights.resize(out.values.rows());
  for (Eigen::Index i = 0; i < out.values.rows(); ++i) {
    const PosteriorSample& sample = posterior.samples[static_cast<std::size_t>(i)];
    const ContactDraw& disc = sample.scene.front();
    out.values.row(i) << disc.centre.x(), disc.centre.y(), disc.size, disc.conductivity_ratio;
    out.weights[i] = sample.weight;
    out.islands.push_back(sample.island);
  }
  return out;
}

TEST(LimitSamplers, AgreeOnADisc) {
  const DiscFrame disc = disc_frame(50, 1);
  const WeightedSamples one = numbers_of(by_importance(disc, 1, 4000));
  RandomStream random(8, key_of("limit test"), 1, Purpose::scene);
  const SceneBank bank = draw_bank(disc.prior, *disc.voltages, 4000, random, 1);
  const FrameLikelihood likelihood(*disc.voltages, disc.noise, disc.frame);
  const PlaceMetric metric(Sensor{}, likelihood.channel_noise(disc.frame));
  const EllipseModel ellipses{Sensor{}};
  const PosteriorSamples annealed =
      sample_by_annealing(disc.prior, likelihood, metric, &ellipses, bank.scenes,
                          likelihood.of_voltages(bank.voltages), AnnealingOptions{}, random);
  const WeightedSamples other = numbers_of(annealed);
  const Eigen::RowVectorXd mean = posterior_mean(one);
  const Eigen::RowVectorXd other_mean = posterior_mean(other);
  for (Eigen::Index p = 0; p < 4; ++p) {
    WeightedSamples single = one;
    single.values = one.values.col(p);
    const double deviation = std::sqrt(total_variance(single));
    single = other;
    single.values = other.values.col(p);
    const double other_deviation = std::sqrt(total_variance(single));
    const double effective = effective_samples(single);
    EXPECT_GT(effective, 30) << p;
    // Five standard deviations of the mean, effective being itself an estimate from four islands.
    EXPECT_NEAR(mean[p], other_mean[p], 5 * deviation / std::sqrt(std::min(effective, 200.0))) << p;
    EXPECT_NEAR(other_deviation / deviation, 1, 0.3) << p;
  }
}

// Without much noise the posterior is the Gaussian of least covariance: (J^T J)^-1 s^2.
TEST(LimitSamplers, MeetTheCramerRaoBoundAtHighSnr) {
  const DiscFrame disc = disc_frame(85, 2);
  const WeightedSamples samples = numbers_of(by_importance(disc, 2, 4000));
  const Scene scene = scene_of(disc.truth);
  const RowMajorMatrix all = BorderModel(Sensor{}).linearise(scene, 3).derivatives;
  Eigen::MatrixX4d jacobian(all.rows(), 4);
  jacobian << all.col(ContactMotion::x), all.col(ContactMotion::y),
      all.col(ContactMotion::growth) / disc.truth[0].size,
      all.col(ContactMotion::log_ratio) / disc.truth[0].conductivity_ratio;
  const double noise =
      FrameLikelihood(*disc.voltages, disc.noise, disc.frame).channel_noise(disc.frame);
  const Eigen::Matrix4d bound = (jacobian.transpose() * jacobian).inverse() * (noise * noise);
  for (Eigen::Index p = 0; p < 4; ++p) {
    WeightedSamples single = samples;
    single.values = samples.values.col(p);
    EXPECT_NEAR(std::sqrt(total_variance(single) / bound(p, p)), 1, 0.06) << p;
  }
}

// Truths drawn from the prior stand anywhere among the samples of their posterior (Talts et al.
// 2018), and are as far from its mean as it says.
TEST(LimitSamplers, AreCalibrated) {
  constexpr int frames = 60;
  bad_tails = 0;
  std::array<std::vector<double>, 4> ranks;
  double error = 0;
  double variance = 0;
  for (int f = 0; f < frames; ++f) {
    const auto number = static_cast<std::uint64_t>(100 + f);
    const DiscFrame disc = disc_frame(50, number);
    const WeightedSamples samples = numbers_of(by_importance(disc, number, 1000));
    const ContactDraw& truth = disc.truth.front();
    const Eigen::Vector4d at(truth.centre.x(), truth.centre.y(), truth.size,
                             truth.conductivity_ratio);
    for (std::size_t p = 0; p < 4; ++p) {
      ranks[p].push_back(weighted_rank(samples.values.col(static_cast<Eigen::Index>(p)),
                                       samples.weights, at[static_cast<Eigen::Index>(p)], 0.5));
    }
    error += (posterior_mean(samples) - at.transpose()).squaredNorm();
    variance += total_variance(samples);
  }
  EXPECT_LE(bad_tails, 3);
  // 1 % of right samplers are farther off: 1.63 / sqrt(60).
  for (const std::vector<double>& of_one : ranks) EXPECT_LT(distance_from_uniform(of_one), 0.21);
  EXPECT_GT(error / variance, 0.5);
  EXPECT_LT(error / variance, 1.8);
}

TEST(EnumeratedDiscs, WeighEveryImageByItsPlaces) {
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.shapes = {DrawnShape::disc};
  scenes.radius = {0.2, 0.2};
  scenes.conductivity_ratio = {0.6, 0.6};
  const ScenePrior prior(scenes, square_sheet());
  const Sensor sensor;
  const auto voltages = grid_voltages(sensor, 24, Rasterisation::centre);
  ASSERT_TRUE(is_enumerable(prior, *voltages));
  const EnumeratedDiscs discs(prior, sensor, *voltages, 24, 8, 1);
  // A frame of little signal, against scenes of the prior weighted by their likelihood.
  RandomStream random(9, key_of("limit test"), 0, Purpose::scene);
  const SceneBank bank = draw_bank(prior, *voltages, 6000, random, 1);
  const Noise noise{26, SnrBasis::absolute};
  Eigen::VectorXd frame = voltages->reference();
  add_noise(noise, voltages->reference(), random, frame);
  const FrameLikelihood likelihood(*voltages, noise, frame);
  PosteriorSamples brute;
  const std::vector<SceneFit> fits = likelihood.of_voltages(bank.voltages);
  double best = -1e300;
  for (const SceneFit& fit : fits) best = std::max(best, fit.log_likelihood);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    brute.samples.push_back({bank.scenes[i], fits[i], std::exp(fits[i].log_likelihood - best), 0});
  }
  const WeightedSamples summed = numbers_of(discs.posterior(likelihood));
  const WeightedSamples weighted = numbers_of(brute);
  const double effective = effective_samples(weighted);
  ASSERT_GT(effective, 40);
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    WeightedSamples one = summed;
    one.values = summed.values.col(axis);
    const double deviation = std::sqrt(total_variance(one));
    EXPECT_NEAR(posterior_mean(one)[0], posterior_mean(weighted)[axis],
                5 * deviation / std::sqrt(effective));
  }
}

}  // namespace
}  // namespace ertbench
