// The losses of DD-ERT against their formulas.

#include "models/training/losses.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include "models/training/adversarial_objective.h"

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
  EXPECT_FALSE(objective.collapse().has_value());
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

}  // namespace
}  // namespace ertbench
