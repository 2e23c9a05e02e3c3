#include <gtest/gtest.h>

#include <cmath>

#include "forward/data/faults.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

TEST(RandomStream, KnownAnswerOfPhilox) {
  // Philox4x64-10 with key 0 and counter 0, from the known-answer file of Random123.
  r123::Philox4x64::ctr_type counter{};
  r123::Philox4x64::key_type key{};
  EXPECT_EQ(r123::Philox4x64()(counter, key)[0], 0x16554d9eca36314cull);
}

TEST(RandomStream, DependsOnEveryPartOfItsKey) {
  const auto first = [](std::uint64_t seed, std::uint64_t set, std::uint64_t scene,
                        Purpose purpose) { return RandomStream(seed, set, scene, purpose).bits(); };
  const std::uint64_t reference = first(1, 2, 3, Purpose::scene);
  EXPECT_EQ(first(1, 2, 3, Purpose::scene), reference);
  EXPECT_NE(first(9, 2, 3, Purpose::scene), reference);
  EXPECT_NE(first(1, 9, 3, Purpose::scene), reference);
  EXPECT_NE(first(1, 2, 9, Purpose::scene), reference);
  EXPECT_NE(first(1, 2, 3, Purpose::noise), reference);
}

TEST(RandomStream, UniformAndNormalHaveTheirMoments) {
  RandomStream random(4, 0, 0, Purpose::noise);
  constexpr int n = 200000;
  double u1 = 0, u2 = 0, z1 = 0, z2 = 0, z4 = 0;
  for (int i = 0; i < n; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0);
    ASSERT_LT(u, 1);
    const double z = random.normal();
    u1 += u / n;
    u2 += u * u / n;
    z1 += z / n;
    z2 += z * z / n;
    z4 += z * z * z * z / n;
  }
  // Five standard errors: sqrt(var / n) with var 1/12, 4/45, 1, 2, 96.
  const double root = 5 / std::sqrt(double(n));
  EXPECT_NEAR(u1, 0.5, root * std::sqrt(1.0 / 12));
  EXPECT_NEAR(u2, 1.0 / 3, root * std::sqrt(4.0 / 45));
  EXPECT_NEAR(z1, 0, root);
  EXPECT_NEAR(z2, 1, root * std::sqrt(2.0));
  EXPECT_NEAR(z4, 3, root * std::sqrt(96.0));
}

class NoiseInBothBases : public ::testing::TestWithParam<SnrBasis> {};

TEST_P(NoiseInBothBases, HasTheSetStrengthAndIsWhite) {
  const Noise noise{40, GetParam()};
  const ForwardModel model(Sensor{}, 24);
  const Eigen::VectorXd& reference = model.reference_voltages();
  const Eigen::VectorXd clean = 1.05 * reference + Eigen::VectorXd::LinSpaced(208, -0.01, 0.01);
  const double signal =
      (GetParam() == SnrBasis::absolute ? clean : Eigen::VectorXd(clean - reference)).norm();
  constexpr int frames = 4000;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(208);
  Eigen::VectorXd square = mean;
  double neighbours = 0;
  for (int i = 0; i < frames; ++i) {
    RandomStream random(1, 2, static_cast<std::uint64_t>(i), Purpose::noise);
    Eigen::VectorXd frame = clean;
    add_noise(noise, reference, random, frame);
    const Eigen::VectorXd added = (frame - clean) / signal * std::pow(10, 2.0);
    // 20 log10(|signal| / |noise|) = 40 exactly, frame by frame.
    ASSERT_NEAR(added.norm(), 1, 1e-11);
    const Eigen::VectorXd scaled = added * std::sqrt(208.0);
    mean += scaled / frames;
    square += scaled.cwiseAbs2() / frames;
    neighbours += scaled.head(207).dot(scaled.tail(207)) / (207.0 * frames);
  }
  // Each channel: mean 0 and variance 1, within five standard errors over 208 channels.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 5 / std::sqrt(double(frames)));
  EXPECT_LT((square.array() - 1).abs().maxCoeff(), 5 * std::sqrt(2.0 / frames));
  EXPECT_LT(std::abs(neighbours), 5 / std::sqrt(207.0 * frames));
}

INSTANTIATE_TEST_SUITE_P(Bases, NoiseInBothBases,
                         ::testing::Values(SnrBasis::absolute, SnrBasis::difference),
                         [](const auto& basis) { return std::string(name_of(basis.param)); });

TEST(Noise, NoneLeavesTheFrameAlone) {
  RandomStream random(1, 2, 3, Purpose::noise);
  const Eigen::VectorXd reference = Eigen::VectorXd::Ones(208);
  Eigen::VectorXd frame = 2 * reference;
  add_noise({}, reference, random, frame);
  EXPECT_EQ(frame, 2 * reference);
  frame = reference;  // a blank frame has no signal in the difference basis
  add_noise({50, SnrBasis::difference}, reference, random, frame);
  EXPECT_EQ(frame, reference);
}

}  // namespace
}  // namespace ertbench
