#include "models/solvers/sensitivity.h"
#include "models/solvers/solvers.h"

namespace ertbench {

void DdErtSolver::check(const Sensor& sensor) const { DdErtGenerator::check(sensor); }

void DdErtSolver::read(JsonObject object) {
  shape_.width = object.integer_or("width", shape_.width, 1, 1024);
  shape_.convolutions = object.integer_or("convolutions", shape_.convolutions, 1, 16);
  shape_.attention = object.boolean_or("attention", shape_.attention);
  physics_ = object.choice_or("initialisation", physics_ ? "physics" : "random",
                              {"physics", "random"}) == "physics";
  train_dense_ = object.boolean_or("train_dense", train_dense_);
  AdversarialSettings& a = adversarial_;
  a.squared_content =
      object.choice_or("content_loss", a.squared_content ? "mse" : "l1", {"l1", "mse"}) == "mse";
  a.alpha = object.number_or("alpha", a.alpha, {0, 1e6});
  a.beta = object.number_or("beta", a.beta, {0, 1e6});
  a.form = adversarial_form_from_name(object.choice_or(
      "adversarial_form", name_of(a.form), {"minimax", "non-saturating", "least-squares"}));
  a.mask_threshold = object.number_or("mask_threshold", a.mask_threshold, {0, 1, true});
  a.discriminator_rate =
      object.number_or("discriminator_rate", a.discriminator_rate, {0, 1000, true});
  a.spectral_norm = object.boolean_or("spectral_norm", a.spectral_norm);
  a.instance_noise = object.number_or("instance_noise", a.instance_noise, {0, 10});
  a.label_smoothing = object.number_or("label_smoothing", a.label_smoothing, {0, 0.49});
  if (object.has("discriminator_widths")) {
    const std::vector<int> widths = object.integers("discriminator_widths", 2, 2, {1, 4096});
    std::copy(widths.begin(), widths.end(), a.discriminator_widths.begin());
  }
  training_ = TrainingSettings::from_json(
      object, {.batch = 16, .learning_rate = 4e-3, .freeze_statistics = 0.4});
  object.finish();
}

nlohmann::json DdErtSolver::settings() const {
  const AdversarialSettings& a = adversarial_;
  nlohmann::json out = {{"width", shape_.width},
                        {"convolutions", shape_.convolutions},
                        {"attention", shape_.attention},
                        {"initialisation", physics_ ? "physics" : "random"},
                        {"train_dense", train_dense_},
                        {"content_loss", a.squared_content ? "mse" : "l1"},
                        {"alpha", a.alpha},
                        {"beta", a.beta},
                        {"adversarial_form", name_of(a.form)},
                        {"mask_threshold", a.mask_threshold},
                        {"discriminator_rate", a.discriminator_rate},
                        {"discriminator_widths", a.discriminator_widths}};
  // As in the files of networks from before there were these: left out where they are off.
  if (a.spectral_norm) out["spectral_norm"] = true;
  if (a.instance_noise > 0) out["instance_noise"] = a.instance_noise;
  if (a.label_smoothing > 0) out["label_smoothing"] = a.label_smoothing;
  return out;
}

std::shared_ptr<Network> DdErtSolver::make_network(const Sensor& sensor) const {
  return std::make_shared<DdErtGenerator>(sensor, shape_);
}

void DdErtSolver::initialise(Network& network, const FitInput& input,
                             const Standardisation& standardisation) const {
  torch::nn::Linear& dense = dynamic_cast<DdErtGenerator&>(network).initial_imaging();
  if (physics_) set_sensitivity_inverse(dense, input, standardisation);
  if (!train_dense_) {
    dense->weight.set_requires_grad(false);
    dense->bias.set_requires_grad(false);
  }
}

std::unique_ptr<Objective> DdErtSolver::make_objective(const FitInput&) const {
  AdversarialSettings settings = adversarial_;
  settings.bfloat16 = training_.bfloat16;
  settings.seed = training_.seed;
  return std::make_unique<AdversarialObjective>(settings);
}

}  // namespace ertbench
