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
                                 const torch::Tensor& odds_of_images) {
  if (form == AdversarialForm::least_squares) {
    return (odds_of_truths - 1).square().mean() + odds_of_images.square().mean();
  }
  return F::softplus(-odds_of_truths).mean() + F::softplus(odds_of_images).mean();
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
