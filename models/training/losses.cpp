#include "models/training/losses.h"

#include <torch/nn/functional/activation.h>
#include <torch/nn/functional/loss.h>

namespace ertbench {

namespace F = torch::nn::functional;

AdversarialForm adversarial_form_from_name(const std::string& name) {
  if (name == "non-saturating") return AdversarialForm::non_saturating;
  if (name == "least-squares") return AdversarialForm::least_squares;
  return AdversarialForm::minimax;
}

const char* name_of(AdversarialForm form) {
  switch (form) {
    case AdversarialForm::minimax:
      return "minimax";
    case AdversarialForm::non_saturating:
      return "non-saturating";
    case AdversarialForm::least_squares:
      return "least-squares";
  }
  return "";
}

// With log-odds x: -log D = softplus(-x), -log(1 - D) = softplus(x), which neither overflow nor
// lose the small probabilities.

torch::Tensor discriminator_loss(AdversarialForm form, const torch::Tensor& odds_of_truths,
                                 const torch::Tensor& odds_of_images, double label_smoothing) {
  const double s = label_smoothing;
  if (form == AdversarialForm::least_squares) {
    return (odds_of_truths - (1 - s)).square().mean() + odds_of_images.square().mean();
  }
  torch::Tensor of_truths = F::softplus(-odds_of_truths).mean();
  if (s > 0) of_truths = (1 - s) * of_truths + s * F::softplus(odds_of_truths).mean();
  return of_truths + F::softplus(odds_of_images).mean();
}

double share_judged_right(AdversarialForm form, const torch::Tensor& odds, bool of_truths) {
  // What least squares calls odds is the answer itself, between 0 for images and 1 for truths.
  const double border = form == AdversarialForm::least_squares ? 0.5 : 0;
  const torch::Tensor right = of_truths ? odds > border : odds < border;
  return right.to(torch::kFloat64).mean().item<double>();
}

torch::Tensor generator_loss(AdversarialForm form, const torch::Tensor& odds_of_images) {
  switch (form) {
    case AdversarialForm::minimax:
      return -F::softplus(odds_of_images).mean();
    case AdversarialForm::non_saturating:
      return F::softplus(-odds_of_images).mean();
    case AdversarialForm::least_squares:
      return (odds_of_images - 1).square().mean();
  }
  return {};
}

torch::Tensor mask_loss(const torch::Tensor& images, const torch::Tensor& truths,
                        double threshold) {
  // After a sigmoid this function's gradient is images - truths, also where it saturates.
  return F::binary_cross_entropy(
      images, truths,
      F::BinaryCrossEntropyFuncOptions().weight((truths >= threshold).to(images.dtype())));
}

}  // namespace ertbench
