// The losses of DD-ERT against their formulas.

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "models/training/objective.h"

namespace ertbench {
namespace {

TEST(Losses, MaskLossIsFormulaB5) {
  torch::manual_seed(1);
  const torch::Tensor images = torch::rand({3, 1, 4, 4}) * 0.98 + 0.01;
  const torch::Tensor truths = torch::rand({3, 1, 4, 4}) - 0.4;  // some pixels outside
  const torch::Tensor y = truths.clamp(0, 1);
  double sum = 0;
  for (int i = 0; i < images.numel(); ++i) {
    const double truth = y.flatten()[i].item<double>();
    const double image = images.flatten()[i].item<double>();
    const double mask = truth >= 0.05 ? 1 : 0;
    const double rm = truth * mask;
    const double gm = image * mask;
    if (mask > 0) sum -= rm * std::log(gm) + (1 - rm) * std::log(1 - gm);
  }
  EXPECT_NEAR(mask_loss(images, y, 0.05).item<double>(), sum / static_cast<double>(images.numel()),
              1e-5);
}

TEST(Losses, MaskLossKeepsItsGradientWhereTheSigmoidIsSaturated) {
  const torch::Tensor logits = torch::full({1, 1, 1, 1}, -20.0).set_requires_grad(true);
  const torch::Tensor truth = torch::full({1, 1, 1, 1}, 0.5);
  mask_loss(logits.sigmoid(), truth, 0.05).backward();
  EXPECT_NEAR(logits.grad().item<double>(), -0.5, 1e-3);
}

TEST(Losses, AdversarialFormsAreTheirFormulas) {
  const torch::Tensor of_truths = torch::tensor({1.5, -0.3});
  const torch::Tensor of_images = torch::tensor({-2.0, 0.7});
  const auto d = [](double x) { return 1 / (1 + std::exp(-x)); };
  const double truths = -(std::log(d(1.5)) + std::log(d(-0.3))) / 2;
  const double images = -(std::log(1 - d(-2.0)) + std::log(1 - d(0.7))) / 2;
  for (const AdversarialForm form : {AdversarialForm::minimax, AdversarialForm::non_saturating}) {
    EXPECT_NEAR(discriminator_loss(form, of_truths, of_images).item<double>(), truths + images,
                1e-6);
  }
  EXPECT_NEAR(generator_loss(AdversarialForm::minimax, of_images).item<double>(), -images, 1e-6);
  EXPECT_NEAR(generator_loss(AdversarialForm::non_saturating, of_images).item<double>(),
              -(std::log(d(-2.0)) + std::log(d(0.7))) / 2, 1e-6);
  EXPECT_NEAR(
      discriminator_loss(AdversarialForm::least_squares, of_truths, of_images).item<double>(),
      (0.25 + 1.69) / 2 + (4 + 0.49) / 2, 1e-6);
  EXPECT_NEAR(generator_loss(AdversarialForm::least_squares, of_images).item<double>(),
              (9 + 0.09) / 2, 1e-6);
}

/// The log-odds at which a gradient descent on the discriminator's loss comes to rest.
double odds_at_rest(AdversarialForm form, double smoothing) {
  torch::Tensor odds = torch::zeros({1}, torch::kFloat64).set_requires_grad(true);
  const torch::Tensor of_images = torch::tensor({-1.0}, torch::kFloat64);
  for (int step = 0; step < 2000; ++step) {
    discriminator_loss(form, odds, of_images, smoothing).backward();
    const torch::NoGradGuard no_gradients;
    odds -= 0.5 * odds.grad();
    odds.mutable_grad().zero_();
  }
  return odds.item<double>();
}

TEST(Losses, SmoothedLabelsPutTheMinimumAtTheirOdds) {
  for (const double s : {0.1, 0.3}) {
    EXPECT_NEAR(odds_at_rest(AdversarialForm::minimax, s), std::log((1 - s) / s), 1e-6);
    EXPECT_NEAR(odds_at_rest(AdversarialForm::non_saturating, s), std::log((1 - s) / s), 1e-6);
    EXPECT_NEAR(odds_at_rest(AdversarialForm::least_squares, s), 1 - s, 1e-6);
  }
}

TEST(Losses, OnlyTheLabelsOfTruthsAreSmoothed) {
  const torch::Tensor of_truths = torch::tensor({1.5, -0.3});
  const auto change = [&](double of_images) {
    const torch::Tensor odds = torch::full({2}, of_images);
    const AdversarialForm form = AdversarialForm::minimax;
    return (discriminator_loss(form, of_truths, odds, 0.2) -
            discriminator_loss(form, of_truths, odds))
        .item<double>();
  };
  EXPECT_NEAR(change(-2), change(3), 1e-5);
  EXPECT_GT(std::abs(change(-2)), 0.01);
}

TEST(Losses, WhatIsJudgedRightIsOnTheRightSideOfTheBorder) {
  const torch::Tensor odds = torch::tensor({1.5, -0.3, 0.2, 0.7});
  EXPECT_EQ(share_judged_right(AdversarialForm::minimax, odds, true), 0.75);
  EXPECT_EQ(share_judged_right(AdversarialForm::minimax, odds, false), 0.25);
  EXPECT_EQ(share_judged_right(AdversarialForm::least_squares, odds, true), 0.5);
  EXPECT_EQ(share_judged_right(AdversarialForm::least_squares, odds, false), 0.5);
}

TEST(Losses, InstanceNoiseFallsToZero) {
  InstanceNoise noise(0.2, 1);
  const torch::Tensor images = torch::zeros({4, 1, 64, 64});
  const std::uint64_t steps = 11;
  for (const std::uint64_t step : {0u, 5u, 9u}) {
    noise.begin_step(step, steps);
    const double expected = 0.2 * (1 - static_cast<double>(step) / 10);
    EXPECT_NEAR(noise.deviation(), expected, 1e-12);
    // Of 16384 numbers the deviation is uncertain by 1 / sqrt(2 * 16384) = 0.55 %.
    EXPECT_NEAR(noise.add_to(images).std().item<double>(), expected, 0.03 * expected);
  }
  noise.begin_step(10, steps);
  EXPECT_TRUE(noise.add_to(images).equal(images));
}

TEST(Losses, InstanceNoiseDependsOnSeedAndStepAlone) {
  const torch::Tensor images = torch::zeros({2, 1, 24, 24});
  InstanceNoise one(0.2, 7);
  one.begin_step(0, 10);
  one.add_to(images);
  torch::randn({5});  // torch's own stream plays no part
  one.begin_step(3, 10);
  InstanceNoise other(0.2, 7);
  other.begin_step(3, 10);
  const torch::Tensor first = one.add_to(images);
  EXPECT_TRUE(first.equal(other.add_to(images)));
  EXPECT_FALSE(first.equal(one.add_to(images)));  // truths and images have noise of their own
  InstanceNoise seeded(0.2, 8);
  seeded.begin_step(3, 10);
  EXPECT_FALSE(first.equal(seeded.add_to(images)));
}

TEST(Losses, ObjectiveIsTheWeightedSumOfItsTerms) {
  torch::manual_seed(2);
  const torch::Tensor truths = torch::rand({4, 1, 24, 24}).round() * 0.4;
  const torch::Tensor images = torch::rand({4, 1, 24, 24});
  AdversarialSettings settings;
  settings.alpha = 0.5;
  settings.beta = 2;
  AdversarialObjective objective(settings);
  objective.set_learning_rate(1e-3);
  std::vector<double> terms;
  const double total = objective.loss(images, truths, terms).item<double>();
  ASSERT_EQ(terms.size(), objective.terms().size());
  EXPECT_NEAR(total, terms[0] + 0.5 * terms[1] + 2 * terms[2], 1e-6);
  EXPECT_NEAR(terms[0], (images - truths).abs().mean().item<double>(), 1e-6);
}

TEST(Losses, DiscriminatorLearnsToTellWhatIsTrue) {
  torch::manual_seed(3);
  AdversarialSettings settings;
  settings.alpha = 1;
  settings.discriminator_rate = 1;
  AdversarialObjective objective(settings);
  objective.set_learning_rate(1e-3);
  std::vector<double> terms;
  double first = 0;
  for (int step = 0; step < 30; ++step) {
    const torch::Tensor truths = torch::rand({8, 1, 24, 24}).round();
    const torch::Tensor blurred = torch::rand({8, 1, 24, 24}) * 0.1 + 0.45;
    objective.loss(blurred, truths, terms);
    if (step == 0) first = terms[3];
  }
  EXPECT_LT(terms[3], 0.2 * first);
  EXPECT_EQ(terms[4], 1);  // the game is over
  EXPECT_EQ(terms[5], 1);
  EXPECT_FALSE(objective.collapse().has_value());
}

TEST(Losses, WithoutADiscriminatorThereIsNoGameToReport) {
  AdversarialObjective objective(AdversarialSettings{.alpha = 0});
  std::vector<double> terms;
  const torch::Tensor images = torch::full({2, 1, 24, 24}, 0.5);
  objective.loss(images, images, terms);
  EXPECT_EQ(terms.size(), objective.terms().size());
  EXPECT_EQ(objective.terms().back(), "discriminator");
}

TEST(Losses, ADiscriminatorThatSaysNothingIsReported) {
  AdversarialObjective objective(AdversarialSettings{});
  objective.set_learning_rate(0);
  std::vector<double> terms;
  const torch::Tensor blank = torch::zeros({4, 1, 24, 24});
  objective.loss(blank, blank, terms);
  // Only the padding at the borders makes the patches of a blank image differ.
  const auto spread_over_padding = objective.collapse();
  EXPECT_FALSE(spread_over_padding.has_value());
  EXPECT_TRUE(objective.collapse().has_value());  // an epoch in which it never spoke
}

/// In between the loss is that without a game, and the discriminator stays as it is.
TEST(AdversarialObjective, PlaysInEveryFourthStepWithFourTimesTheWeight) {
  torch::manual_seed(1);
  const torch::Tensor images = torch::rand({4, 1, 24, 24});
  const torch::Tensor truths = torch::rand({4, 1, 24, 24});
  AdversarialSettings settings;
  settings.discriminator_widths = {4, 8};
  settings.every = 4;
  AdversarialObjective game(settings);
  settings.alpha = 0;
  AdversarialObjective none(settings);
  std::vector<double> terms;
  const double without = none.loss(images, truths, terms).item<double>();
  double played = 0;
  for (std::uint64_t step = 0; step < 9; ++step) {
    SCOPED_TRACE(step);
    const NamedTensors before = copies(game.state());
    game.begin_step(step, 9);
    const double loss = game.loss(images, truths, terms).item<double>();
    const bool plays = step % 4 == 0;
    EXPECT_NEAR(loss, without + (plays ? 4e-3 * terms[1] : 0), 1e-6);
    EXPECT_EQ(game.state().front().values.equal(before.front().values), !plays);
    if (plays) played = terms[1];
    EXPECT_NEAR(terms[1], played, 1e-6);
  }
}

}  // namespace
}  // namespace ertbench
