// Each sampler on targets whose posterior is known, and on frames against each other.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "forward/border/border_model.h"
#include "forward/border/contact_electrodes.h"
#include "forward/sheet/sheet_shapes.h"
#include "limit/annealed_sampler.h"
#include "limit/frame_limit.h"
#include "limit/posterior_sampler.h"
#include "tests/bench/limit_testing.h"

namespace ertbench {
namespace {

using testing::distance_from_uniform;

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
  PosteriorSamples out = sample_disc_by_importance(
      disc.prior, likelihood, bank.scenes, likelihood.of_voltages(bank.voltages), points, random);
  if (out.pareto_k > 0.7) ++bad_tails;
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

// Left and right, and up and down, are alike on a rectangle.
TEST(PlaceMetric, HasTheSymmetryOfARectangle) {
  Sensor sensor;
  sensor.sheet = std::make_shared<const RectangleSheet>(Eigen::Vector2d(300, 150));
  const PlaceMetric metric(sensor, 1e-3);
  const auto at = [&](double x, double y) {
    ContactDraw contact;
    contact.centre = {x, y};
    contact.size = 0.1;
    contact.conductivity_ratio = 0.5;
    return metric.information(contact);
  };
  const Eigen::Matrix3d one = at(0.7, 0.3);
  for (const Eigen::Matrix3d& other : {at(-0.7, 0.3), at(0.7, -0.3), at(-0.7, -0.3)}) {
    EXPECT_NEAR(other(2, 2) / one(2, 2), 1, 0.05);
    EXPECT_NEAR(other(0, 0) / one(0, 0), 1, 0.05);
  }
  // Next to the border, where the electrodes are, more is known than in the middle.
  EXPECT_GT(one(2, 2), 2 * at(0, 0)(2, 2));
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
