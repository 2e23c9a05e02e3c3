#include "models/training/adversarial_objective.h"

#include <torch/nn/functional/loss.h>

#include <algorithm>

#include "models/networks/reduced_precision.h"
#include "models/training/adam_state.h"

namespace ertbench {
namespace {

/// Log-odds that differ by less over all patches of all images of an epoch say nothing.
constexpr double least_judgement_spread = 1e-4;

/// Places among the terms; the last two only with a discriminator.
enum Term : std::size_t {
  content_term,
  adversarial_term,
  mask_term,
  discriminator_term,
  right_truths_term,
  right_images_term
};

void set_trainable(PatchDiscriminator& discriminator, bool trainable) {
  for (torch::Tensor& parameter : discriminator->parameters()) {
    parameter.set_requires_grad(trainable);
  }
}

}  // namespace

AdversarialObjective::AdversarialObjective(const AdversarialSettings& settings)
    : settings_(settings), noise_(settings.instance_noise, settings.seed) {
  if (settings_.alpha == 0) return;
  discriminator_ = PatchDiscriminator(settings_.discriminator_widths, settings_.spectral_norm);
  optimiser_ = std::make_unique<torch::optim::Adam>(
      discriminator_->parameters(), torch::optim::AdamOptions().betas({0.5, 0.999}));
}

std::vector<std::string> AdversarialObjective::terms() const {
  std::vector<std::string> names = {"content", "adversarial", "mask", "discriminator"};
  if (optimiser_) {
    names.insert(names.end(), {"discriminator_right_truths", "discriminator_right_images"});
  }
  return names;
}

torch::Tensor AdversarialObjective::odds(const torch::Tensor& images) {
  const ReducedPrecision precision(settings_.bfloat16);
  return discriminator_->forward(noise_.add_to(images)).to(torch::kFloat32);
}

void AdversarialObjective::train_discriminator(const torch::Tensor& images,
                                               const torch::Tensor& truths,
                                               std::vector<double>& terms) {
  set_trainable(discriminator_, true);
  optimiser_->zero_grad();
  const torch::Tensor of_truths = odds(truths);
  const torch::Tensor of_images = odds(images.detach());
  const torch::Tensor loss =
      discriminator_loss(settings_.form, of_truths, of_images, settings_.label_smoothing);
  loss.backward();
  optimiser_->step();
  const auto spread = [](const torch::Tensor& tensor) {
    const torch::Tensor all = tensor.detach();
    return (all.max() - all.min()).item<double>();
  };
  largest_spread_ = std::max({largest_spread_, spread(of_truths), spread(of_images)});
  set_trainable(discriminator_, false);  // what follows is the generator's step
  terms[discriminator_term] = loss.item<double>();
  terms[right_truths_term] = share_judged_right(settings_.form, of_truths.detach(), true);
  terms[right_images_term] = share_judged_right(settings_.form, of_images.detach(), false);
}

torch::Tensor AdversarialObjective::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                         std::vector<double>& terms) {
  namespace F = torch::nn::functional;
  torch::Tensor total =
      settings_.squared_content ? F::mse_loss(images, truths) : F::l1_loss(images, truths);
  terms.assign(optimiser_ ? right_images_term + 1 : discriminator_term + 1, 0.0);
  terms[content_term] = total.item<double>();
  if (optimiser_) {
    train_discriminator(images, truths, terms);
    const torch::Tensor adversarial = generator_loss(settings_.form, odds(images));
    terms[adversarial_term] = adversarial.item<double>();
    total = total + settings_.alpha * adversarial;
  }
  if (settings_.beta != 0) {
    const torch::Tensor mask = mask_loss(images, truths, settings_.mask_threshold);
    terms[mask_term] = mask.item<double>();
    total = total + settings_.beta * mask;
  }
  return total;
}

void AdversarialObjective::begin_step(std::uint64_t step, std::uint64_t steps) {
  noise_.begin_step(step, steps);
}

void AdversarialObjective::set_learning_rate(double learning_rate) {
  if (!optimiser_) return;
  for (auto& group : optimiser_->param_groups()) {
    group.options().set_lr(settings_.discriminator_rate * learning_rate);
  }
}

std::optional<std::string> AdversarialObjective::collapse() {
  if (!optimiser_) return std::nullopt;
  const double spread = std::exchange(largest_spread_, 0.0);
  if (spread >= least_judgement_spread) return std::nullopt;
  return "discriminator collapsed";
}

NamedTensors AdversarialObjective::state() const {
  NamedTensors all;
  if (!optimiser_) return all;
  append(all, "discriminator.", weights_of(*discriminator_));
  append(all, "optimiser.", state_of(*optimiser_));
  return all;
}

void AdversarialObjective::set_state(const NamedTensors& state) {
  if (!optimiser_) return;
  const NamedTensors weights = weights_of(*discriminator_);
  copy_values(state, weights);
  ertbench::set_state(*optimiser_,
                      {state.begin() + static_cast<std::ptrdiff_t>(weights.size()), state.end()});
}

}  // namespace ertbench
