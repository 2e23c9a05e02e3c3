#include "models/training/objective.h"

#include <ATen/CPUGeneratorImpl.h>
#include <torch/nn/functional/activation.h>
#include <torch/nn/functional/loss.h>

#include <algorithm>

#include "core/random.h"
#include "models/networks/torch_runtime.h"

namespace ertbench {

torch::Tensor sheet_mask(const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  if (pixels.all_on_sheet()) return {};
  torch::Tensor mask = torch::zeros({1, 1, pixels.rows(), pixels.columns()});
  for (int p = 0; p < pixels.count(); ++p) mask.data_ptr<float>()[p] = pixels.on_sheet(p) ? 1 : 0;
  return mask;
}

namespace F = torch::nn::functional;

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
  // For least squares the "odds" are the output itself, between 0 for images and 1 for truths.
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

namespace {

constexpr double error_floor = 0.01;
constexpr double truth_floor = 0.55;

torch::Tensor relative_error(const torch::Tensor& images, const torch::Tensor& truths) {
  const auto norm = [](const torch::Tensor& maps, double floor) {
    return (maps.flatten(1).square().sum(1) + floor * floor).sqrt();
  };
  return (norm(images - truths, error_floor) / norm(truths, truth_floor)).mean();
}

}  // namespace

torch::Tensor SquaredError::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                 std::vector<double>&) {
  const torch::Tensor target =
      blur_.defined() ? truths.flatten(1).matmul(blur_.t()).view_as(truths) : truths;
  return torch::nn::functional::mse_loss(images, target);
}

torch::Tensor RelativeError::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                  std::vector<double>&) {
  return relative_error(images, truths);
}

void InstanceNoise::begin_step(std::uint64_t step, std::uint64_t steps) {
  if (largest_ == 0) return;
  const double place = steps > 1 ? static_cast<double>(step) / static_cast<double>(steps - 1) : 0;
  deviation_ = largest_ * (1 - place);
  RandomStream random(seed_, key_of("instance noise"), step, Purpose::training);
  generator_ = at::make_generator<at::CPUGeneratorImpl>(random.bits());
}

torch::Tensor InstanceNoise::add_to(const torch::Tensor& images) {
  if (deviation_ == 0) return images;
  return images + deviation_ * torch::randn(images.sizes(), generator_).to(images.device());
}

namespace {

/// A discriminator with a smaller range of log-odds over an epoch has collapsed.
constexpr double least_judgement_spread = 1e-4;

/// Indices of the terms; the last two only with a discriminator.
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
  optimiser_ = std::make_unique<Adam>(std::vector<Adam::Group>{discriminator_->parameters()}, 0.5);
}

void AdversarialObjective::to(torch::Device device) {
  if (discriminator_) discriminator_->to(device);
}

std::vector<std::string> AdversarialObjective::terms() const {
  std::vector<std::string> names = {"content", "adversarial", "mask", "discriminator"};
  if (optimiser_) {
    names.insert(names.end(), {"discriminator_right_truths", "discriminator_right_images"});
  }
  return names;
}

torch::Tensor AdversarialObjective::odds(const torch::Tensor& images) {
  const ReducedPrecision precision(settings_.bfloat16, images.device());
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
  set_trainable(discriminator_, false);  // for the generator's step
  terms[discriminator_term] = loss.item<double>();
  terms[right_truths_term] = share_judged_right(settings_.form, of_truths.detach(), true);
  terms[right_images_term] = share_judged_right(settings_.form, of_images.detach(), false);
}

torch::Tensor AdversarialObjective::loss(const torch::Tensor& images, const torch::Tensor& truths,
                                         std::vector<double>& terms) {
  namespace F = torch::nn::functional;
  torch::Tensor total = settings_.content == ContentLoss::l1    ? F::l1_loss(images, truths)
                        : settings_.content == ContentLoss::mse ? F::mse_loss(images, truths)
                                                                : relative_error(images, truths);
  terms.assign(optimiser_ ? right_images_term + 1 : discriminator_term + 1, 0.0);
  terms[content_term] = total.item<double>();
  if (optimiser_ && plays_) {
    train_discriminator(images, truths, terms);
    const torch::Tensor adversarial = generator_loss(settings_.form, odds(images));
    terms[adversarial_term] = adversarial.item<double>();
    total = total + settings_.every * settings_.alpha * adversarial;
    played_ = torch::tensor(terms).to(torch::kFloat32);
  } else if (optimiser_) {  // the log goes on with the last move
    for (const Term term :
         {adversarial_term, discriminator_term, right_truths_term, right_images_term}) {
      terms[term] = played_[term].item<double>();
    }
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
  plays_ = step % static_cast<std::uint64_t>(settings_.every) == 0;
}

void AdversarialObjective::set_learning_rate(double learning_rate) {
  if (!optimiser_) return;
  optimiser_->set_rate(0, settings_.discriminator_rate * learning_rate);
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
  append(all, "optimiser.", optimiser_->state());
  if (settings_.every > 1) all.push_back({"played", played_});
  return all;
}

void AdversarialObjective::set_state(const NamedTensors& state) {
  if (!optimiser_) return;
  const NamedTensors weights = weights_of(*discriminator_);
  copy_values(state, weights);
  const auto first = state.begin() + static_cast<std::ptrdiff_t>(weights.size());
  const auto last = state.end() - (settings_.every > 1);
  optimiser_->set_state({first, last});
  if (last != state.end()) played_ = last->values;
}

}  // namespace ertbench
